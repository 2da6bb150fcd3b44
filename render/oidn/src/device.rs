//! A device, and one run of the filter `RT` on it.

use std::ffi::{CStr, c_char, c_int, c_void};
use std::ptr;
use std::sync::Arc;

use crate::api::{Api, CANCELLED, CPU, FLOAT3, Handle, Monitor, OUT_OF_MEMORY};

/// What an image is to the filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Radiance, the image to filter unless there is none.
    Color,
    /// Albedo from 0 to 1.
    Albedo,
    /// Normals from -1 to 1.
    Normal,
}

impl Role {
    fn name(self) -> &'static CStr {
        match self {
            Self::Color => c"color",
            Self::Albedo => c"albedo",
            Self::Normal => c"normal",
        }
    }
}

/// An image: three numbers a pixel, row by row.
#[derive(Clone, Copy, Debug)]
pub struct Image<'a> {
    /// What it is.
    pub role: Role,
    /// As many as the size says.
    pub pixels: &'a [[f32; 3]],
}

/// Why there is no result.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FilterError {
    /// Whoever watched has stopped it.
    #[error("stopped")]
    Stopped,
    /// There is not enough memory.
    #[error("Open Image Denoise: out of memory: {0}")]
    Memory(String),
    /// Another error of the library.
    #[error("Open Image Denoise: {0}")]
    Failed(String),
    /// An image that has not as many pixels as the size says.
    #[error("the image has {found} pixels in place of {expected}")]
    Size {
        /// The image's.
        found: usize,
        /// The errors of the size.
        expected: usize,
    },
}

/// A device on the CPU.
pub struct Device {
    api: Arc<Api>,
    handle: Handle,
}

/// A filter that is released in the end.
struct Filter<'a> {
    api: &'a Api,
    handle: Handle,
}

/// Receives the progress of a run, from 0 to 1, and returns whether to continue. Called from any thread.
type Watcher<'a> = &'a (dyn Fn(f64) -> bool + Sync);

impl Device {
    pub(crate) fn new(api: Arc<Api>, threads: u32) -> Result<Self, FilterError> {
        // SAFETY: a call without pointers. A null handle means an error.
        let handle = unsafe { (api.new_device)(CPU) };
        let device = Self { api, handle };
        if handle.is_null() {
            return Err(device.error().unwrap_or_else(|| FilterError::Failed("there is no CPU device".to_owned())));
        }
        if threads > 0 {
            // SAFETY: the device is alive, and the name ends in zero.
            unsafe { (device.api.set_device_int)(handle, c"numThreads".as_ptr(), threads as c_int) };
        }
        // SAFETY: the device is alive.
        unsafe { (device.api.commit_device)(handle) };
        device.error().map_or(Ok(device), Err)
    }

    /// A parameter of the device.
    pub(crate) fn int(&self, name: &CStr) -> u32 {
        // SAFETY: the device is alive, and the name ends in zero.
        let value = unsafe { (self.api.get_device_int)(self.handle, name.as_ptr()) };
        u32::try_from(value).unwrap_or(0)
    }

    /// Filters the first of `images`, guided by the others, which are free of noise if `clean`.
    ///
    /// # Errors
    /// If an image has another size, the library fails, or `watch` says no.
    pub fn run(
        &self,
        (width, height): (usize, usize),
        images: &[Image],
        clean: bool,
        watch: Watcher,
    ) -> Result<Vec<[f32; 3]>, FilterError> {
        let expected = width * height;
        if let Some(image) = images.iter().find(|image| image.pixels.len() != expected) {
            return Err(FilterError::Size { found: image.pixels.len(), expected });
        }
        let mut output = vec![[0.0_f32; 3]; expected];
        if expected == 0 {
            return Ok(output);
        }
        // SAFETY: the device is alive, and the name ends in zero.
        let handle = unsafe { (self.api.new_filter)(self.handle, c"RT".as_ptr()) };
        if handle.is_null() {
            return Err(self.error().unwrap_or_else(|| FilterError::Failed("there is no filter RT".to_owned())));
        }
        let filter = Filter { api: &self.api, handle };
        let set = |name: &CStr, pixels: *mut c_void| {
            // SAFETY: `pixels` are `width * height` times three floats without gaps, checked above, which live and are
            // not moved until the filter is released at the end of this function. The filter only reads images that are
            // not called "output".
            unsafe { (self.api.set_shared_image)(handle, name.as_ptr(), pixels, FLOAT3, width, height, 0, 0, 0) };
        };
        for image in images {
            set(image.role.name(), image.pixels.as_ptr().cast_mut().cast());
        }
        set(c"output", output.as_mut_ptr().cast());
        let flag = |name: &CStr, value: bool| {
            // SAFETY: the filter is alive, and the name ends in zero.
            unsafe { (self.api.set_filter_bool)(handle, name.as_ptr(), value) };
        };
        if images.iter().any(|image| image.role == Role::Color) {
            flag(c"hdr", true);
            flag(c"cleanAux", clean);
        }
        let mut watcher = watch;
        let monitor: Monitor = monitor;
        // SAFETY: the filter is alive. `watcher` outlives it, as it is released first, and `monitor` takes just that
        // type.
        unsafe { (self.api.set_monitor)(handle, Some(monitor), ptr::from_mut(&mut watcher).cast()) };
        // SAFETY: the filter is alive, and all its images and its watcher are.
        unsafe { (self.api.commit_filter)(handle) };
        if let Some(error) = self.error() {
            return Err(error);
        }
        // SAFETY: the same. The call returns when all is done.
        unsafe { (self.api.execute_filter)(handle) };
        drop(filter);
        self.error().map_or(Ok(output), Err)
    }

    /// The first error since the last time; of the thread, if there is no device.
    fn error(&self) -> Option<FilterError> {
        let mut text: *const c_char = ptr::null();
        // SAFETY: `text` may be written to; null means the thread's own errors.
        let code = unsafe { (self.api.get_device_error)(self.handle, &raw mut text) };
        let message = if text.is_null() {
            format!("error {code}")
        } else {
            // SAFETY: the library says that it is a string that ends in zero, valid until the next error of this
            // device.
            unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned()
        };
        match code {
            0 => None,
            CANCELLED => Some(FilterError::Stopped),
            OUT_OF_MEMORY => Some(FilterError::Memory(message)),
            _ => Some(FilterError::Failed(message)),
        }
    }
}

/// Hands the library's progress on.
unsafe extern "C" fn monitor(user: *mut c_void, done: f64) -> bool {
    // SAFETY: `user` is the `Watcher` that `Device::run` has given, alive while the filter runs, and shared between
    // threads (it is `Sync`) without being changed.
    let watch = unsafe { &*user.cast::<Watcher>() };
    watch(done)
}

impl Drop for Filter<'_> {
    fn drop(&mut self) {
        // SAFETY: the filter is alive, and released once.
        unsafe { (self.api.release_filter)(self.handle) };
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        if !self.handle.is_null() {
            // SAFETY: the device is alive, and released once; filters borrow it, so there are none.
            unsafe { (self.api.release_device)(self.handle) };
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU32, Ordering};

    use super::*;
    use crate::{Library, VARIABLE};

    /// The library, or a word that there is none.
    fn library() -> Option<Library> {
        let found = Library::find();
        if let Err(error) = &found {
            eprintln!("skipped, as {VARIABLE} leads to no Open Image Denoise: {error}");
        }
        found.ok()
    }

    #[test]
    fn a_filter_hears_its_watcher() {
        let Some(library) = library() else { return };
        assert!(library.version().major >= 2);
        let device = library.device(1).unwrap();
        let pixels = vec![[0.5, 0.25, 1.0]; 64 * 48];
        let images = [Image { role: Role::Color, pixels: &pixels }];
        let calls = AtomicU32::new(0);
        let count = |_| calls.fetch_add(1, Ordering::Relaxed) < u32::MAX;
        let output = device.run((64, 48), &images, false, &count).unwrap();
        // It may err at the borders, a little.
        let errors = output.iter().flatten().zip(pixels.iter().flatten()).map(|(a, b)| (a / b - 1.0).abs());
        assert!(errors.sum::<f32>() < 0.02 * (3 * pixels.len()) as f32);
        assert!(calls.load(Ordering::Relaxed) > 0);
        assert_eq!(device.run((64, 48), &images, false, &|_| false), Err(FilterError::Stopped));
        let error = device.run((64, 49), &images, false, &|_| true);
        assert_eq!(error, Err(FilterError::Size { found: 64 * 48, expected: 64 * 49 }));
    }
}
