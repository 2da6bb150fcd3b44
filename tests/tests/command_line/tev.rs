//! A growing picture in tev, replaced by a listener that reads its protocol.

use std::collections::BTreeMap;
use std::io::Read;
use std::net::{TcpListener, TcpStream};
use std::thread;

use halfdome::output::read_exr;

use crate::Desk;

/// A packet's fields, from its first byte on.
struct Packet(Vec<u8>, usize);

impl Packet {
    fn next(stream: &mut TcpStream) -> Option<Self> {
        let mut length = [0; 4];
        stream.read_exact(&mut length).ok()?;
        let mut bytes = vec![0; u32::from_le_bytes(length) as usize - 4];
        stream.read_exact(&mut bytes).unwrap();
        Some(Self(bytes, 0))
    }

    fn take<const N: usize>(&mut self) -> [u8; N] {
        self.1 += N;
        self.0[self.1 - N..self.1].try_into().unwrap()
    }

    fn number(&mut self) -> usize {
        u32::from_le_bytes(self.take()) as usize
    }

    fn text(&mut self) -> String {
        let end = self.1 + self.0[self.1..].iter().position(|&byte| byte == 0).unwrap();
        let text = String::from_utf8(self.0[self.1..end].to_vec()).unwrap();
        self.1 = end + 1;
        text
    }
}

/// What a viewer has seen: its pictures' sizes by their names, and the last values of each channel.
#[derive(Default)]
struct Seen {
    created: Vec<(String, [usize; 2], usize)>,
    updates: usize,
    channels: BTreeMap<String, Vec<f32>>,
}

fn view(listener: &TcpListener) -> Seen {
    let (mut stream, _) = listener.accept().unwrap();
    let mut seen = Seen::default();
    while let Some(mut packet) = Packet::next(&mut stream) {
        let [kind, _grab] = packet.take();
        let name = packet.text();
        match kind {
            4 => {
                let size = [packet.number(), packet.number()];
                let count = packet.number();
                let names: Vec<String> = (0..count).map(|_| packet.text()).collect();
                seen.created.push((name, size, names.len()));
            }
            6 => {
                assert_eq!(packet.number(), 1);
                let channel = packet.text();
                let [x, y, width, height] = [(); 4].map(|()| packet.number());
                let [_offset, _stride] = [(); 2].map(|()| i64::from_le_bytes(packet.take()));
                assert_eq!((x, y), (0, 0));
                let values = (0..width * height).map(|_| f32::from_le_bytes(packet.take())).collect();
                assert_eq!(packet.1, packet.0.len());
                seen.updates += 1;
                seen.channels.insert(channel, values);
            }
            kind => panic!("a packet of kind {kind}"),
        }
    }
    seen
}

#[test]
fn tev_shows_the_picture_that_is_written() {
    let desk = Desk::new();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let viewer = thread::spawn(move || view(&listener));
    let line = format!("render cornell --size 24x18 --spp 8 --aov --progressive=4 --tev={address} -o a.exr");
    let outcome = desk.run(&line);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let seen = viewer.join().unwrap();
    let picture = read_exr(&desk.folder.path().join("a.exr")).unwrap();
    let (name, size, channels) = seen.created.last().unwrap();
    assert_eq!((name.as_str(), *size, *channels), ("a.exr", [24, 18], picture.channels.len()));
    assert!(seen.updates > picture.channels.len(), "early pictures, too: {}", seen.updates);
    for channel in &picture.channels {
        assert_eq!(seen.channels[&channel.name], channel.values, "{}", channel.name);
    }
}

#[test]
fn a_viewer_that_is_not_there_is_told_before_the_render_and_one_that_goes_does_not_stop_it() {
    let desk = Desk::new();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let viewer = thread::spawn(move || drop(listener.accept().unwrap()));
    let outcome = desk.run(&format!("render cornell --size 64x64 --spp 32 --tev={address} -o a.exr"));
    viewer.join().unwrap();
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(desk.folder.path().join("a.exr").exists());
    // Nobody listens at that place any more.
    let line = format!("render cornell --size 8x8 --spp 1 --tev={address} -o b.exr");
    desk.refuses(&line, 1, &["there is no tev at 127.0.0.1:", "start tev", "--tev=HOST:PORT"]);
    desk.refuses("render cornell --size 8x8 --spp 1 --tev=nowhere -o b.exr", 1, &["there is no tev at nowhere"]);
}
