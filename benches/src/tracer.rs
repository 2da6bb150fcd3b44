//! The ways to trace a slice of rays: the kernel's entry points here, those of its peers in the binary `peers`.

use halfdome_kernel::traverse::{PacketWidth, Width};
use halfdome_kernel::{BvhView, Hit, HitPacket, Ray, RayPacket};

/// Something that traces rays, on one thread.
pub trait Tracer {
    /// Writes the nearest hit of each ray, or [`Hit::MISS`]. The slices are of equal length.
    fn intersect(&self, rays: &[Ray], hits: &mut [Hit]);

    /// Writes for each ray whether it hits anything. The slices are of equal length.
    fn occluded(&self, rays: &[Ray], occluded: &mut [bool]);
}

impl<T: Tracer + ?Sized> Tracer for &T {
    fn intersect(&self, rays: &[Ray], hits: &mut [Hit]) {
        (**self).intersect(rays, hits);
    }

    fn occluded(&self, rays: &[Ray], occluded: &mut [bool]) {
        (**self).occluded(rays, occluded);
    }
}

/// An entry point of the kernel; scenes have the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
    /// `intersect` and `occluded`.
    Single,
    /// `intersect_packet::<4>` and `occluded_packet::<4>`; gathering the packets counts.
    Packet4,
    /// `intersect_packet::<8>` and `occluded_packet::<8>`.
    Packet8,
    /// `intersect_packet::<16>` and `occluded_packet::<16>`.
    Packet16,
    /// `intersect_packet::<32>` and `occluded_packet::<32>`.
    Packet32,
    /// `intersect_many` and `occluded_many`.
    Batch,
    /// `intersect_gather` and `occluded_gather`.
    Gather,
}

impl Entry {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Single, Self::Packet4, Self::Packet8, Self::Packet16, Self::Packet32, Self::Batch, Self::Gather];

    /// A short name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Single => "single",
            Self::Packet4 => "packet4",
            Self::Packet8 => "packet8",
            Self::Packet16 => "packet16",
            Self::Packet32 => "packet32",
            Self::Batch => "batch",
            Self::Gather => "gather",
        }
    }

    /// This entry point to `tree`.
    pub fn tracer<'a>(self, tree: BvhView<'a>) -> Box<dyn Tracer + 'a> {
        match self {
            Self::Single => Box::new(Single(tree)),
            Self::Packet4 => Box::new(Packets::<4>(tree)),
            Self::Packet8 => Box::new(Packets::<8>(tree)),
            Self::Packet16 => Box::new(Packets::<16>(tree)),
            Self::Packet32 => Box::new(Packets::<32>(tree)),
            Self::Batch => Box::new(Batch(tree)),
            Self::Gather => Box::new(Gather(tree)),
        }
    }
}

/// [`Entry::Batch`] on the threads of a pool, each with an equal part of the rays.
pub struct Threads<'a>(pub BvhView<'a>, pub rayon::ThreadPool);

impl Threads<'_> {
    fn each<T: Send>(&self, rays: &[Ray], answers: &mut [T], trace: impl Fn(&[Ray], &mut [T]) + Sync) {
        let part = rays.len().div_ceil(self.1.current_num_threads()).max(1);
        self.1.scope(|scope| {
            for (rays, answers) in rays.chunks(part).zip(answers.chunks_mut(part)) {
                scope.spawn(|_| trace(rays, answers));
            }
        });
    }
}

impl Tracer for Threads<'_> {
    fn intersect(&self, rays: &[Ray], hits: &mut [Hit]) {
        self.each(rays, hits, |rays, hits| self.0.intersect_many(rays, hits));
    }

    fn occluded(&self, rays: &[Ray], occluded: &mut [bool]) {
        self.each(rays, occluded, |rays, occluded| self.0.occluded_many(rays, occluded));
    }
}

struct Single<'a>(BvhView<'a>);

impl Tracer for Single<'_> {
    fn intersect(&self, rays: &[Ray], hits: &mut [Hit]) {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = self.0.intersect(ray).unwrap_or(Hit::MISS);
        }
    }

    fn occluded(&self, rays: &[Ray], occluded: &mut [bool]) {
        for (ray, occluded) in rays.iter().zip(occluded) {
            *occluded = self.0.occluded(ray);
        }
    }
}

struct Packets<'a, const N: usize>(BvhView<'a>);

impl<const N: usize> Tracer for Packets<'_, N>
where
    Width<N>: PacketWidth<N>,
{
    fn intersect(&self, rays: &[Ray], hits: &mut [Hit]) {
        for (rays, hits) in rays.chunks(N).zip(hits.chunks_mut(N)) {
            let mut packet = HitPacket::<N>::MISS;
            self.0.intersect_packet(&RayPacket::from_rays(rays), &mut packet);
            for (lane, hit) in hits.iter_mut().enumerate() {
                *hit = packet.hit(lane);
            }
        }
    }

    fn occluded(&self, rays: &[Ray], occluded: &mut [bool]) {
        for (rays, occluded) in rays.chunks(N).zip(occluded.chunks_mut(N)) {
            let bits = self.0.occluded_packet(&RayPacket::<N>::from_rays(rays));
            for (lane, occluded) in occluded.iter_mut().enumerate() {
                *occluded = bits >> lane & 1 == 1;
            }
        }
    }
}

struct Batch<'a>(BvhView<'a>);

impl Tracer for Batch<'_> {
    fn intersect(&self, rays: &[Ray], hits: &mut [Hit]) {
        self.0.intersect_many(rays, hits);
    }

    fn occluded(&self, rays: &[Ray], occluded: &mut [bool]) {
        self.0.occluded_many(rays, occluded);
    }
}

struct Gather<'a>(BvhView<'a>);

impl Tracer for Gather<'_> {
    fn intersect(&self, rays: &[Ray], hits: &mut [Hit]) {
        self.0.intersect_gather(rays, hits);
    }

    fn occluded(&self, rays: &[Ray], occluded: &mut [bool]) {
        self.0.occluded_gather(rays, occluded);
    }
}
