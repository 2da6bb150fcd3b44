//! Embree 4 through its C API, loaded at run time.
//!
//! Layouts and constants are those of Embree 4.4's `rtcore_ray.h`, `rtcore_scene.h`, `rtcore_geometry.h` and
//! `rtcore_device.h` with one level of instances and instance arrays, as its releases are built. A library built
//! without instance arrays has smaller hits, and then leaves the last word alone.

use std::ffi::{c_char, c_int, c_uint, c_void};
use std::path::Path;
use std::ptr;
use std::sync::atomic::{AtomicIsize, Ordering};

use halfdome_benches::tracer::Tracer;
use halfdome_kernel::{Hit, Ray, Triangle};
use libloading::Library;

use crate::trees::Peer;

/// `RTC_INVALID_GEOMETRY_ID`.
const INVALID: u32 = u32::MAX;
/// `RTC_RAY_QUERY_FLAG_COHERENT`.
const COHERENT: u32 = 1 << 16;
/// `RTC_BUILD_QUALITY_HIGH`: spatial splits.
const QUALITY_HIGH: c_int = 2;
const GEOMETRY_TRIANGLE: c_int = 0;
const BUFFER_INDEX: c_int = 0;
const BUFFER_VERTEX: c_int = 1;
const FORMAT_UINT3: c_int = 0x5003;
const FORMAT_FLOAT3: c_int = 0x9003;

type Handle = *mut c_void;

/// `RTCRayHitNt<N>`, and for N = 1 `RTCRayHit`. Its alignment is the largest that any width asks for.
#[repr(C, align(64))]
struct RayHit<const N: usize> {
    origin: [[f32; N]; 3],
    t_near: [f32; N],
    direction: [[f32; N]; 3],
    time: [f32; N],
    t_far: [f32; N],
    mask: [u32; N],
    id: [u32; N],
    flags: [u32; N],
    normal: [[f32; N]; 3],
    u: [f32; N],
    v: [f32; N],
    prim_id: [u32; N],
    geom_id: [u32; N],
    instance_id: [u32; N],
    instance_prim_id: [u32; N],
}

/// `RTCIntersectArguments`, and `RTCOccludedArguments`, which is alike; with room for the fields of later versions.
#[repr(C)]
struct Arguments {
    flags: u32,
    feature_mask: u32,
    context: Handle,
    filter: Handle,
    intersect: Handle,
    reserved: [u64; 4],
}

/// Which lanes are active: -1 or 0 each.
#[repr(C, align(64))]
struct Valid<const N: usize>([c_int; N]);

type TraceOne = unsafe extern "C" fn(Handle, *mut RayHit<1>, *mut Arguments);
type TracePacket<const N: usize> = unsafe extern "C" fn(*const c_int, Handle, *mut RayHit<N>, *mut Arguments);
type MemoryMonitor = extern "C" fn(*mut c_void, isize, bool) -> bool;

/// The functions of the library that are used; valid while it is loaded.
struct Api {
    new_device: unsafe extern "C" fn(*const c_char) -> Handle,
    device_error: unsafe extern "C" fn(Handle) -> c_int,
    monitor_memory: unsafe extern "C" fn(Handle, MemoryMonitor, *mut c_void),
    release_device: unsafe extern "C" fn(Handle),
    new_scene: unsafe extern "C" fn(Handle) -> Handle,
    set_quality: unsafe extern "C" fn(Handle, c_int),
    commit_scene: unsafe extern "C" fn(Handle),
    release_scene: unsafe extern "C" fn(Handle),
    new_geometry: unsafe extern "C" fn(Handle, c_int) -> Handle,
    new_buffer: unsafe extern "C" fn(Handle, c_int, c_uint, c_int, usize, usize) -> *mut c_void,
    commit_geometry: unsafe extern "C" fn(Handle),
    attach_geometry: unsafe extern "C" fn(Handle, Handle) -> c_uint,
    release_geometry: unsafe extern "C" fn(Handle),
    intersect1: TraceOne,
    occluded1: TraceOne,
    intersect8: TracePacket<8>,
    occluded8: TracePacket<8>,
    intersect16: TracePacket<16>,
    occluded16: TracePacket<16>,
}

/// The loaded library.
pub(crate) struct Embree {
    api: Api,
    /// Keeps what `api` points to in memory.
    _library: Library,
}

impl Embree {
    /// Loads the library at `path`.
    pub(crate) fn load(path: &Path) -> Result<Self, libloading::Error> {
        // SAFETY: the path names Embree, whose initialisers only set up its own state and its task scheduler's.
        let library = unsafe { Library::new(path) }?;
        macro_rules! symbol {
            ($name:literal) => {
                // SAFETY: the field that the pointer goes to has the type of the function of that name in Embree 4's
                // headers, and the library stays loaded as long as the pointer is held.
                *unsafe { library.get($name) }?
            };
        }
        let api = Api {
            new_device: symbol!("rtcNewDevice"),
            device_error: symbol!("rtcGetDeviceError"),
            monitor_memory: symbol!("rtcSetDeviceMemoryMonitorFunction"),
            release_device: symbol!("rtcReleaseDevice"),
            new_scene: symbol!("rtcNewScene"),
            set_quality: symbol!("rtcSetSceneBuildQuality"),
            commit_scene: symbol!("rtcCommitScene"),
            release_scene: symbol!("rtcReleaseScene"),
            new_geometry: symbol!("rtcNewGeometry"),
            new_buffer: symbol!("rtcSetNewGeometryBuffer"),
            commit_geometry: symbol!("rtcCommitGeometry"),
            attach_geometry: symbol!("rtcAttachGeometry"),
            release_geometry: symbol!("rtcReleaseGeometry"),
            intersect1: symbol!("rtcIntersect1"),
            occluded1: symbol!("rtcOccluded1"),
            intersect8: symbol!("rtcIntersect8"),
            occluded8: symbol!("rtcOccluded8"),
            intersect16: symbol!("rtcIntersect16"),
            occluded16: symbol!("rtcOccluded16"),
        };
        Ok(Self { api, _library: library })
    }

    /// Builds a tree over `triangles` in high quality on one thread.
    pub(crate) fn build(&self, triangles: &[Triangle]) -> Result<Scene<'_>, String> {
        let api = &self.api;
        let allocated = Box::new(AtomicIsize::new(0));
        // SAFETY: every handle comes from the library and is used as its headers say. The buffers hold one element for
        // each corner and each triangle, which is what is written to them. The device lives as long as the counter
        // that its monitor writes to: both belong to the scene, which releases the device when dropped.
        unsafe {
            let device = (api.new_device)(c"threads=1".as_ptr());
            if device.is_null() {
                return Err(format!("error {} when making a device", (api.device_error)(ptr::null_mut())));
            }
            (api.monitor_memory)(device, count_bytes, ptr::from_ref(&*allocated).cast_mut().cast());
            let handle = (api.new_scene)(device);
            let mut scene = Scene { api, device, handle, allocated, bytes: 0 };
            (api.set_quality)(handle, QUALITY_HIGH);
            let geometry = (api.new_geometry)(device, GEOMETRY_TRIANGLE);
            let corners = triangles.as_flattened();
            let buffer = |kind, format, count| (api.new_buffer)(geometry, kind, 0, format, 12, count);
            let vertices: *mut [f32; 3] = buffer(BUFFER_VERTEX, FORMAT_FLOAT3, corners.len()).cast();
            let indices: *mut u32 = buffer(BUFFER_INDEX, FORMAT_UINT3, triangles.len()).cast();
            if vertices.is_null() || indices.is_null() {
                (api.release_geometry)(geometry);
                return Err(format!("error {} when making buffers", (api.device_error)(device)));
            }
            for (i, corner) in corners.iter().enumerate() {
                vertices.add(i).write(corner.to_array());
                indices.add(i).write(i as u32);
            }
            (api.commit_geometry)(geometry);
            (api.attach_geometry)(handle, geometry);
            (api.release_geometry)(geometry);
            let before = scene.allocated.load(Ordering::Relaxed);
            (api.commit_scene)(handle);
            scene.bytes = scene.allocated.load(Ordering::Relaxed) - before;
            match (api.device_error)(device) {
                0 => Ok(scene),
                error => Err(format!("error {error} when building")),
            }
        }
    }
}

/// Embree's memory monitor: adds what it allocates and frees to the counter at `counter`.
extern "C" fn count_bytes(counter: *mut c_void, bytes: isize, _post: bool) -> bool {
    // SAFETY: the device was given a pointer to the counter of its scene, which outlives it.
    unsafe { &*counter.cast::<AtomicIsize>() }.fetch_add(bytes, Ordering::Relaxed);
    true
}

/// A tree of Embree's.
pub(crate) struct Scene<'a> {
    api: &'a Api,
    device: Handle,
    handle: Handle,
    allocated: Box<AtomicIsize>,
    bytes: isize,
}

impl Scene<'_> {
    /// Packets of N; `coherent` promises that their rays run alike.
    fn packets<const N: usize>(
        &self,
        intersect: TracePacket<N>,
        occluded: TracePacket<N>,
        coherent: bool,
    ) -> Packets<'_, N> {
        Packets { scene: self, intersect, occluded, flags: if coherent { COHERENT } else { 0 } }
    }
}

impl Peer for Scene<'_> {
    /// Memory of the tree, without the vertices and indices given to it.
    fn bytes(&self) -> Option<usize> {
        usize::try_from(self.bytes).ok()
    }

    fn tracers(&self, coherent: bool) -> Vec<(&'static str, Box<dyn Tracer + '_>)> {
        let api = self.api;
        vec![
            ("embree_x1", Box::new(Single(self))),
            ("embree_x8", Box::new(self.packets(api.intersect8, api.occluded8, coherent))),
            ("embree_x16", Box::new(self.packets(api.intersect16, api.occluded16, coherent))),
        ]
    }
}

impl Drop for Scene<'_> {
    fn drop(&mut self) {
        // SAFETY: both handles are held once, here, and nothing else uses them afterwards.
        unsafe {
            (self.api.release_scene)(self.handle);
            (self.api.release_device)(self.device);
        }
    }
}

impl<const N: usize> RayHit<N> {
    /// Up to N rays, without hits.
    fn new(rays: &[Ray]) -> Self {
        let ray = |i: usize| &rays[i.min(rays.len() - 1)];
        let lanes = |value: fn(&Ray) -> f32| std::array::from_fn(|i| value(ray(i)));
        Self {
            origin: [lanes(|ray| ray.origin.x), lanes(|ray| ray.origin.y), lanes(|ray| ray.origin.z)],
            t_near: lanes(|ray| ray.t_min),
            direction: [lanes(|ray| ray.direction.x), lanes(|ray| ray.direction.y), lanes(|ray| ray.direction.z)],
            time: [0.0; N],
            t_far: lanes(|ray| ray.t_max),
            mask: [u32::MAX; N],
            id: [0; N],
            flags: [0; N],
            normal: [[0.0; N]; 3],
            u: [0.0; N],
            v: [0.0; N],
            prim_id: [INVALID; N],
            geom_id: [INVALID; N],
            instance_id: [INVALID; N],
            instance_prim_id: [INVALID; N],
        }
    }

    fn hit(&self, lane: usize) -> Hit {
        if self.geom_id[lane] == INVALID {
            return Hit::MISS;
        }
        Hit { t: self.t_far[lane], u: self.u[lane], v: self.v[lane], prim_id: self.prim_id[lane] }
    }

    /// Embree answers an occlusion query with a `t_far` of minus infinity.
    fn is_occluded(&self, lane: usize) -> bool {
        self.t_far[lane] < 0.0
    }
}

struct Single<'a>(&'a Scene<'a>);

impl Single<'_> {
    #[inline]
    fn trace(&self, function: TraceOne, ray: &Ray) -> RayHit<1> {
        let mut query = RayHit::new(std::slice::from_ref(ray));
        // SAFETY: the scene is committed, the query has the layout of RTCRayHit, and no arguments means the defaults.
        unsafe { function(self.0.handle, &mut query, ptr::null_mut()) };
        query
    }
}

impl Tracer for Single<'_> {
    fn intersect(&self, rays: &[Ray], hits: &mut [Hit]) {
        for (ray, hit) in rays.iter().zip(hits) {
            *hit = self.trace(self.0.api.intersect1, ray).hit(0);
        }
    }

    fn occluded(&self, rays: &[Ray], occluded: &mut [bool]) {
        for (ray, occluded) in rays.iter().zip(occluded) {
            *occluded = self.trace(self.0.api.occluded1, ray).is_occluded(0);
        }
    }
}

struct Packets<'a, const N: usize> {
    scene: &'a Scene<'a>,
    intersect: TracePacket<N>,
    occluded: TracePacket<N>,
    flags: u32,
}

impl<const N: usize> Packets<'_, N> {
    #[inline]
    fn trace(&self, function: TracePacket<N>, rays: &[Ray]) -> RayHit<N> {
        let mut query = RayHit::new(rays);
        let valid = Valid::<N>(std::array::from_fn(|lane| if lane < rays.len() { -1 } else { 0 }));
        let none = ptr::null_mut();
        let mut arguments = Arguments {
            flags: self.flags,
            feature_mask: u32::MAX,
            context: none,
            filter: none,
            intersect: none,
            reserved: [0; 4],
        };
        // SAFETY: the scene is committed, and the mask, the query and the arguments have the layouts and alignments
        // that a packet of N asks for.
        unsafe { function(valid.0.as_ptr(), self.scene.handle, &mut query, &mut arguments) };
        query
    }
}

impl<const N: usize> Tracer for Packets<'_, N> {
    fn intersect(&self, rays: &[Ray], hits: &mut [Hit]) {
        for (rays, hits) in rays.chunks(N).zip(hits.chunks_mut(N)) {
            let query = self.trace(self.intersect, rays);
            for (lane, hit) in hits.iter_mut().enumerate() {
                *hit = query.hit(lane);
            }
        }
    }

    fn occluded(&self, rays: &[Ray], occluded: &mut [bool]) {
        for (rays, occluded) in rays.chunks(N).zip(occluded.chunks_mut(N)) {
            let query = self.trace(self.occluded, rays);
            for (lane, occluded) in occluded.iter_mut().enumerate() {
                *occluded = query.is_occluded(lane);
            }
        }
    }
}
