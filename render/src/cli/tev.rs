//! Shows the picture while it is rendered in tev, a viewer of HDR pictures (github.com/Tom94/tev), over its protocol.

use std::io;
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use tev_client::{PacketCreateImage, PacketUpdateImage, TevClient};

use super::error::{CliError, invalid};
use super::messages::{Style, print_warning};
use crate::film::{Film, Picture};

/// The default address of tev.
pub(super) const ADDRESS: &str = "127.0.0.1:14158";

/// How often the picture is sent at most.
const INTERVAL: Duration = Duration::from_secs(1);
/// How long a viewer may take to answer, and to take a part of the picture.
const PATIENCE: Duration = Duration::from_secs(5);

/// A picture in a viewer.
pub(super) struct Tev {
    name: String,
    style: Style,
    /// Until it breaks.
    viewer: Mutex<Option<Viewer>>,
}

struct Viewer {
    client: TevClient,
    /// The channels and the size of the picture that it shows.
    shown: Option<(Vec<String>, (u32, u32))>,
    last: Instant,
}

impl Tev {
    /// Reaches a viewer, which shows the picture under a name.
    ///
    /// # Errors
    /// If there is none.
    pub(super) fn connect(address: &str, name: &str, style: Style) -> Result<Self, CliError> {
        let connect = || -> io::Result<TcpStream> {
            let mut error = io::Error::new(io::ErrorKind::NotFound, "there is no such host");
            for address in address.to_socket_addrs()? {
                match TcpStream::connect_timeout(&address, PATIENCE) {
                    Ok(stream) => {
                        stream.set_write_timeout(Some(PATIENCE))?;
                        return Ok(stream);
                    }
                    Err(found) => error = found,
                }
            }
            Err(error)
        };
        let stream = connect().map_err(|error| {
            let remedy = format!("start tev, which listens at {ADDRESS}, or name another place: --tev=HOST:PORT");
            invalid(format!("there is no tev at {address}: {error}"), remedy)
        })?;
        let viewer = Viewer { client: TevClient::wrap(stream), shown: None, last: Instant::now() };
        Ok(Self { name: name.to_owned(), style, viewer: Mutex::new(Some(viewer)) })
    }

    /// Shows the colours of a film, but not too often.
    pub(super) fn show_film(&self, film: &Film) {
        self.with_viewer(|viewer| {
            let is_early = viewer.shown.is_some() && viewer.last.elapsed() < INTERVAL;
            if is_early { Ok(()) } else { viewer.show(&self.name, &film.picture(), true) }
        });
    }

    /// Shows a picture: its colours, or all channels.
    pub(super) fn show(&self, picture: &Picture, colors_only: bool) {
        self.with_viewer(|viewer| viewer.show(&self.name, picture, colors_only));
    }

    /// A viewer that has gone is no reason to stop.
    fn with_viewer(&self, work: impl FnOnce(&mut Viewer) -> io::Result<()>) {
        let Ok(mut place) = self.viewer.lock() else { return };
        if let Some(viewer) = place.as_mut()
            && let Err(error) = work(viewer)
        {
            print_warning(self.style, &format!("tev is gone, the render continues without it: {error}"));
            *place = None;
        }
    }
}

impl Viewer {
    fn show(&mut self, name: &str, picture: &Picture, colors_only: bool) -> io::Result<()> {
        let (width, height) = (picture.width, picture.height);
        let names: Vec<&str> = picture.channels.iter().map(|channel| channel.name.as_str()).collect();
        let is_shown = self.shown.as_ref().is_some_and(|(shown, size)| *shown == names && *size == (width, height));
        if !is_shown {
            let create = PacketCreateImage { image_name: name, grab_focus: true, width, height, channel_names: &names };
            self.client.send(create)?;
            self.shown = Some((names.iter().map(|&name| name.to_owned()).collect(), (width, height)));
        }
        let is_color = |name: &str| ["R", "G", "B", "A"].contains(&name);
        for channel in picture.channels.iter().filter(|channel| !colors_only || is_color(&channel.name)) {
            self.client.send(PacketUpdateImage {
                image_name: name,
                grab_focus: false,
                channel_names: &[channel.name.as_str()],
                channel_offsets: &[0],
                channel_strides: &[1],
                x: 0,
                y: 0,
                width,
                height,
                data: &channel.values,
            })?;
        }
        self.last = Instant::now();
        Ok(())
    }
}
