//! The atlas: which texels belong to which triangles.
//!
//! A *page* is a map. A *part* is the portion of a mesh on one page, with vertices of its own where the border of a
//! chart cuts the mesh; a *chart* is a connected piece of a part in the plane of the page. Texture coordinates are
//! glTF's: from the top left corner, v down, so that texel row 0 is the first row of a picture.

use glam::{DVec2, Vec2};

use super::left_out::LeftOut;
use crate::scene::Scene;

/// Stands for no chart.
pub const NO_CHART: u32 = u32::MAX;

/// Pages with the charts of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Atlas {
    /// The maps.
    pub pages: Vec<Page>,
    /// The scene's meshes but its lamps, in the order of the scene, each in one part or, where it fits on no page, in
    /// several.
    pub parts: Vec<Part>,
    /// The pieces, part by part.
    pub charts: Vec<Chart>,
    /// Triangles without a chart, although they have an area.
    pub left_out: LeftOut,
    /// What was wrong with the model's own coordinates, and why there are many pages; a line each.
    pub warnings: Vec<String>,
}

/// The size of a map in texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Page {
    /// Across.
    pub width: u32,
    /// Down.
    pub height: u32,
}

/// What of a mesh lies on one page.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Index of the mesh in the scene.
    pub mesh: usize,
    /// Index of the page.
    pub page: usize,
    /// The vertices that its triangles use.
    pub vertices: Vec<Vertex>,
    /// Three indices into `vertices` each, in the order of the mesh's corners.
    pub triangles: Vec<[u32; 3]>,
    /// The index of each triangle in the mesh.
    pub faces: Vec<u32>,
    /// The chart of each triangle; [`NO_CHART`] if it has no area.
    pub charts: Vec<u32>,
    /// The source of its coordinates.
    pub layout: Layout,
}

/// A vertex of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// The mesh's vertex that all but the coordinates are of.
    pub source: u32,
    /// Coordinates on the page, from 0 to 1.
    pub uv: Vec2,
}

/// The source of coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// They are the model's, vertex by vertex.
    Kept,
    /// The model's charts have new places.
    Repacked,
    /// They are new.
    Unwrapped,
}

/// A connected piece.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Index of its part.
    pub part: usize,
    /// Its triangles, as indices into those of the part.
    pub triangles: Vec<u32>,
    /// The least coordinates on the page.
    pub min: Vec2,
    /// The greatest.
    pub max: Vec2,
    /// Its area in the scene, square units.
    pub area: f32,
    /// Its area on the page, square texels.
    pub texels: f32,
}

impl Page {
    /// The number of texels.
    pub fn texels(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Coordinates in texels.
    pub(crate) fn to_texels(self, uv: Vec2) -> DVec2 {
        uv.as_dvec2() * DVec2::new(self.width.into(), self.height.into())
    }
}

impl Part {
    /// The corners of a triangle in texels of its page.
    pub(crate) fn corners(&self, triangle: usize, page: Page) -> [DVec2; 3] {
        self.triangles[triangle].map(|vertex| page.to_texels(self.vertices[vertex as usize].uv))
    }
}

impl Chart {
    /// Texels in a unit of length, on average.
    pub fn density(&self) -> f32 {
        (self.texels / self.area).sqrt()
    }
}

/// A mesh for messages.
pub(crate) fn mesh_name(scene: &Scene, mesh: usize) -> String {
    match scene.meshes[mesh].name.as_str() {
        "" => format!("mesh {mesh}"),
        name => format!("mesh {mesh} ({name:?})"),
    }
}
