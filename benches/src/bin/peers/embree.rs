//! Embree 4 through its C API, loaded at run time.
//!
//! Functions and constants are those of Embree 4.4's `rtcore_device.h`, `rtcore_scene.h`, `rtcore_geometry.h` and
//! `rtcore_common.h`; what it reads and writes is in [`layout`](crate::layout). All unsafe code of the benchmarks is
//! here.

use std::error::Error;
use std::ffi::{c_char, c_int, c_uint, c_void};
use std::mem;
use std::path::Path;
use std::ptr;
use std::sync::atomic::{AtomicIsize, Ordering};

use glam::Affine3A;
use halfdome_benches::tracer::Tracer;
use halfdome_kernel::{Hit, Ray, Triangle};
use libloading::Library;

use crate::layout::{Arguments, COHERENT, INCOHERENT, RayHit, Valid};
use crate::trees::Peer;

/// `RTC_BUILD_QUALITY_HIGH`: spatial splits.
const QUALITY_HIGH: c_int = 2;
const GEOMETRY_TRIANGLE: c_int = 0;
const GEOMETRY_INSTANCE: c_int = 121;
const BUFFER_INDEX: c_int = 0;
const BUFFER_VERTEX: c_int = 1;
const FORMAT_UINT3: c_int = 0x5003;
const FORMAT_FLOAT3: c_int = 0x9003;
const FORMAT_FLOAT3X4_COLUMN_MAJOR: c_int = 0x9234;
const PROPERTY_VERSION_MAJOR: c_int = 1;

/// Bytes that all devices hold: a C callback has no better place to count them.
static ALLOCATED: AtomicIsize = AtomicIsize::new(0);

type Handle = *mut c_void;

type TraceOne = unsafe extern "C" fn(Handle, *mut RayHit<1>, *mut Arguments);
type TracePacket<const N: usize> = unsafe extern "C" fn(*const c_int, Handle, *mut RayHit<N>, *mut Arguments);
type MemoryMonitor = extern "C" fn(*mut c_void, isize, bool) -> bool;

/// The functions of the library that are used; valid while it is loaded.
struct Api {
    new_device: unsafe extern "C" fn(*const c_char) -> Handle,
    device_property: unsafe extern "C" fn(Handle, c_int) -> isize,
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
    set_instanced_scene: unsafe extern "C" fn(Handle, Handle),
    set_transform: unsafe extern "C" fn(Handle, c_uint, c_int, *const f32),
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
    ///
    /// # Errors
    /// If there is no library there, or it is not Embree.
    pub(crate) fn load(path: &Path) -> Result<Self, String> {
        let reason = |error: libloading::Error| match error.source() {
            // The loader's own words, which name the file.
            Some(source) => source.to_string(),
            None => format!("{}: {error}", path.display()),
        };
        // SAFETY: the path names Embree, whose initialisers only set up its own state and its task scheduler's.
        let library = unsafe { Library::new(path) }.map_err(reason)?;
        macro_rules! symbol {
            ($name:literal) => {
                // SAFETY: the field that the pointer goes to has the type of the function of that name in Embree 4's
                // headers, and the library stays loaded as long as the pointer is held.
                *unsafe { library.get($name) }.map_err(reason)?
            };
        }
        let api = Api {
            new_device: symbol!("rtcNewDevice"),
            device_property: symbol!("rtcGetDeviceProperty"),
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
            set_instanced_scene: symbol!("rtcSetGeometryInstancedScene"),
            set_transform: symbol!("rtcSetGeometryTransform"),
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
    ///
    /// # Errors
    /// Embree's error code, or its version if that is not 4.
    pub(crate) fn build(&self, triangles: &[Triangle]) -> Result<Scene<'_>, String> {
        let api = &self.api;
        // SAFETY: every handle comes from the library and is used as its headers say. The buffers hold one element for
        // each corner and each triangle, which is what is written to them.
        unsafe {
            let device = (api.new_device)(c"threads=1".as_ptr());
            if device.is_null() {
                return Err(format!("error {} when making a device", (api.device_error)(ptr::null_mut())));
            }
            (api.monitor_memory)(device, count_bytes, ptr::null_mut());
            let handle = (api.new_scene)(device);
            let mut scene = Scene { api, device, handle, bytes: 0, instances: Vec::new(), inner: ptr::null_mut() };
            // Embree 3 has functions of the same names and other arguments.
            let version = (api.device_property)(device, PROPERTY_VERSION_MAJOR);
            if version != 4 {
                return Err(format!("the library is version {version}, this needs version 4"));
            }
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
            let before = ALLOCATED.load(Ordering::Relaxed);
            (api.commit_scene)(handle);
            scene.bytes = ALLOCATED.load(Ordering::Relaxed) - before;
            match (api.device_error)(device) {
                0 => Ok(scene),
                error => Err(format!("error {error} when building")),
            }
        }
    }
}

impl<'a> Scene<'a> {
    /// A scene of instances of this one, each where a transform takes it.
    ///
    /// # Errors
    /// Embree's error code.
    pub(crate) fn instances(mut self, places: &[Affine3A]) -> Result<Self, String> {
        let Api { new_scene, new_geometry, set_instanced_scene, attach_geometry, .. } = *self.api;
        // SAFETY: every handle comes from the library and is used as its headers say.
        unsafe {
            self.inner = mem::replace(&mut self.handle, new_scene(self.device));
            for _ in places {
                let instance = new_geometry(self.device, GEOMETRY_INSTANCE);
                set_instanced_scene(instance, self.inner);
                attach_geometry(self.handle, instance);
                self.instances.push(instance);
            }
        }
        self.move_instances(places);
        // SAFETY: the device is this scene's own.
        match unsafe { (self.api.device_error)(self.device) } {
            0 => Ok(self),
            error => Err(format!("error {error} when building instances")),
        }
    }

    /// Puts each instance where a transform takes it, and commits the scene.
    pub(crate) fn move_instances(&self, places: &[Affine3A]) {
        for (&instance, place) in self.instances.iter().zip(places) {
            let columns = place.to_cols_array();
            // SAFETY: the handle is an instance's, and twelve numbers are what a matrix of three rows and four columns
            // has.
            unsafe {
                (self.api.set_transform)(instance, 0, FORMAT_FLOAT3X4_COLUMN_MAJOR, columns.as_ptr());
                (self.api.commit_geometry)(instance);
            }
        }
        // SAFETY: the handle is this scene's own.
        unsafe { (self.api.commit_scene)(self.handle) };
    }
}

/// Embree's memory monitor: counts what is allocated and freed, and lets it go on.
extern "C" fn count_bytes(_user: *mut c_void, bytes: isize, _post: bool) -> bool {
    ALLOCATED.fetch_add(bytes, Ordering::Relaxed);
    true
}

/// A tree of Embree's.
pub(crate) struct Scene<'a> {
    api: &'a Api,
    device: Handle,
    handle: Handle,
    bytes: isize,
    instances: Vec<Handle>,
    /// What they are instances of, or null.
    inner: Handle,
}

impl Scene<'_> {
    /// Packets of N; `coherent` promises that their rays run alike.
    fn packets<const N: usize>(
        &self,
        intersect: TracePacket<N>,
        occluded: TracePacket<N>,
        coherent: bool,
    ) -> Packets<'_, N> {
        Packets { scene: self, intersect, occluded, flags: if coherent { COHERENT } else { INCOHERENT } }
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
        // SAFETY: each handle is held once, here, and nothing else uses them afterwards.
        unsafe {
            self.instances.iter().for_each(|&instance| (self.api.release_geometry)(instance));
            (self.api.release_scene)(self.handle);
            if !self.inner.is_null() {
                (self.api.release_scene)(self.inner);
            }
            (self.api.release_device)(self.device);
        }
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
        let valid = Valid::<N>::first(rays.len());
        let mut arguments = Arguments::new(self.flags);
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
