//! The atlas: which texels belong to which triangles.
//!
//! A *page* is a map. A *part* is what of a mesh lies on one page, with vertices of its own where the border of a chart
//! cuts the mesh; a *chart* is a connected piece of a part in the plane of the page. Texture coordinates are glTF's: from
//! the top left corner, v down, so that texel row 0 is the first row of a picture.

use glam::{DVec2, Vec2};

use super::check::{Check, check};
use super::edges::SharedEdge;
use super::islands::islands;
use super::options::{BakeOptions, Coordinates};
use super::unwrap::{Request, unwrap};
use crate::scene::{Scene, count};
use crate::settings::Invalid;

/// Stands for no chart.
pub const NO_CHART: u32 = u32::MAX;

/// The most texels of all pages together.
const MAX_TEXELS: u64 = 1 << 28;

/// Pages with the charts of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Atlas {
    /// The maps.
    pub pages: Vec<Page>,
    /// The scene's meshes in the order of the scene, each in one part or, where it fits on no page, in several.
    pub parts: Vec<Part>,
    /// The pieces, part by part.
    pub charts: Vec<Chart>,
    /// What was wrong with the model's own coordinates, a line each.
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
    /// For each triangle its number in the mesh.
    pub faces: Vec<u32>,
    /// For each triangle its chart; [`NO_CHART`] if it has no area.
    pub charts: Vec<u32>,
    /// Where its coordinates come from.
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

/// Where coordinates come from.
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

impl Atlas {
    /// Pages for all meshes of a scene whose shared edges are known.
    ///
    /// # Errors
    /// If pages are too small or texels too many, or if the model's own coordinates must be kept and cannot.
    pub(crate) fn build(scene: &Scene, edges: &[SharedEdge], options: &BakeOptions) -> Result<Self, Invalid> {
        if let Some(density) = options.density.filter(|density| !density.is_finite() || *density <= 0.0) {
            return Err(Invalid::new(
                format!("a density of {density} texels per unit is none"),
                "give a number of texels that is more than 0",
            ));
        }
        let mut atlas = Self::default();
        let requests = atlas.keep(scene, options)?;
        let (pages, parts) = unwrap(scene, edges, &requests, options, atlas.pages.len())?;
        atlas.pages.extend(pages);
        atlas.parts.extend(parts);
        let texels: u64 = atlas.pages.iter().map(|page| page.texels() as u64).sum();
        if texels > MAX_TEXELS {
            return Err(Invalid::new(
                format!("{} have {texels} texels together", count(atlas.pages.len(), "page", "pages")),
                format!("give a lower --density: a bake has at most {MAX_TEXELS} texels"),
            ));
        }
        atlas.parts.sort_by_key(|part| (part.mesh, part.page));
        atlas.charts = islands(scene, &atlas.pages, &mut atlas.parts);
        if atlas.charts.is_empty() {
            return Err(Invalid::new("no triangle has an area", "give a model with surfaces"));
        }
        Ok(atlas)
    }

    /// The coordinates that the scene's meshes have, right or wrong, on one page; `None` if none has any or they are not to
    /// be used.
    ///
    /// # Errors
    /// If the density that is asked for makes too large a page of them.
    pub fn of_model(scene: &Scene, options: &BakeOptions) -> Result<Option<Self>, Invalid> {
        let own: Vec<usize> = own_coordinates(scene).collect();
        if own.is_empty() || options.coordinates == Coordinates::New {
            return Ok(None);
        }
        Self::given(scene, &own, options).map(Some)
    }

    /// What is right and wrong with the coordinates, for charts that keep `padding` texels to themselves.
    pub fn check(&self, scene: &Scene, options: &BakeOptions) -> Check {
        check(scene, self, options.padding())
    }

    /// Takes meshes over whose coordinates can be kept; gives the others.
    fn keep(&mut self, scene: &Scene, options: &BakeOptions) -> Result<Vec<Request>, Invalid> {
        let request = |mesh, repack| Request { mesh, repack };
        let has_own = |mesh: usize| !scene.meshes[mesh].lightmap_texcoords.is_empty();
        let must = options.coordinates == Coordinates::Keep;
        if let Some(without) = (0..scene.meshes.len()).find(|&mesh| must && !has_own(mesh)) {
            return Err(Invalid::new(
                format!("{} has no second set of texture coordinates", mesh_name(scene, without)),
                "give it one, or leave --uv out",
            ));
        }
        if options.coordinates == Coordinates::New {
            return Ok((0..scene.meshes.len()).map(|mesh| request(mesh, false)).collect());
        }
        let own: Vec<usize> = own_coordinates(scene).collect();
        let given = Self::given(scene, &own, options)?;
        let found = check(scene, &given, options.padding());
        let mut usable = vec![false; scene.meshes.len()];
        for (number, &mesh) in own.iter().enumerate() {
            let faults = found.faults_of(&given, number);
            usable[mesh] = faults.is_empty();
            if !usable[mesh] {
                let problem = format!("the second texture coordinates of {} {faults}", mesh_name(scene, mesh));
                if must {
                    return Err(Invalid::new(problem, "mend them, or leave --uv out for new ones"));
                }
                self.warnings.push(format!("{problem}; new ones are made"));
            }
        }
        let is_shared = found.overlaps.iter().any(|overlap| {
            let [a, b] = overlap.charts.map(|chart| given.parts[given.charts[chart].part].mesh);
            a != b && usable[a] && usable[b]
        });
        if is_shared {
            let problem = "meshes lie on each other in their second texture coordinates";
            if must {
                return Err(Invalid::new(problem, "give each mesh a place of its own, or leave --uv out"));
            }
            self.warnings.push(format!("{problem}; their charts get new places"));
        } else if usable.contains(&true) {
            self.pages = given.pages;
            self.parts = given.parts.into_iter().filter(|part| usable[part.mesh]).collect();
        }
        let others = (0..scene.meshes.len()).filter(|&mesh| is_shared || !usable[mesh]);
        Ok(others.map(|mesh| request(mesh, usable[mesh])).collect())
    }

    /// The coordinates that `meshes` have, as parts of one page.
    fn given(scene: &Scene, meshes: &[usize], options: &BakeOptions) -> Result<Self, Invalid> {
        let parts: Vec<Part> = meshes
            .iter()
            .map(|&index| {
                let mesh = &scene.meshes[index];
                let vertices = (0..).zip(&mesh.lightmap_texcoords).map(|(source, &uv)| Vertex { source, uv });
                Part {
                    mesh: index,
                    page: 0,
                    vertices: vertices.collect(),
                    triangles: mesh.triangles.clone(),
                    faces: (0..mesh.triangles.len() as u32).collect(),
                    charts: vec![NO_CHART; mesh.triangles.len()],
                    layout: Layout::Kept,
                }
            })
            .collect();
        let size = match options.density {
            None => options.size,
            Some(density) => kept_size(scene, &parts, density)?,
        };
        let mut given = Self { pages: vec![Page { width: size, height: size }], parts, ..Self::default() };
        given.charts = islands(scene, &given.pages, &mut given.parts);
        Ok(given)
    }
}

/// The meshes with lightmap coordinates.
fn own_coordinates(scene: &Scene) -> impl Iterator<Item = usize> {
    (0..scene.meshes.len()).filter(|&mesh| !scene.meshes[mesh].lightmap_texcoords.is_empty())
}

/// The size of a page on which parts have this density on average.
fn kept_size(scene: &Scene, parts: &[Part], density: f32) -> Result<u32, Invalid> {
    let unit = Page { width: 1, height: 1 };
    let (mut area, mut covered) = (0.0, 0.0);
    for part in parts {
        for (triangle, &face) in part.faces.iter().enumerate() {
            let on_page = super::raster::Polygon::triangle(part.corners(triangle, unit)).area().abs();
            if on_page.is_finite() {
                covered += on_page;
                area += super::islands::area(scene.meshes[part.mesh].corners(face as usize));
            }
        }
    }
    let size = if covered > 0.0 { f64::from(density) * (area / covered).sqrt() } else { 1.0 };
    if size > f64::from(BakeOptions::MAX_SIZE) {
        return Err(Invalid::new(
            format!("the model's own layout needs {size:.0} texels a side at {density} texels per unit"),
            format!("give a lower --density: a page has at most {} texels a side", BakeOptions::MAX_SIZE),
        ));
    }
    Ok((size.ceil() as u32).max(BakeOptions::MIN_SIZE))
}

/// A mesh for messages.
pub(crate) fn mesh_name(scene: &Scene, mesh: usize) -> String {
    match scene.meshes[mesh].name.as_str() {
        "" => format!("mesh {mesh}"),
        name => format!("mesh {mesh} ({name:?})"),
    }
}
