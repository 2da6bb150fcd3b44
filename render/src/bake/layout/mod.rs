//! Lays out an atlas: some meshes keep their coordinates, some get new places for their charts, and some are unwrapped.

pub mod atlas;
pub mod check;
pub(super) mod edges;
pub(super) mod islands;
pub(super) mod left_out;
pub(super) mod raster;
pub(super) mod room;
mod t_junctions;
pub(super) mod texels;
mod unwrap;

use super::options::{BakeOptions, Coordinates};
use crate::scene::{Scene, count};
use crate::settings::Invalid;
use atlas::{Atlas, Layout, NO_CHART, Page, Part, Vertex, mesh_name};
use check::{Check, check};
use edges::SharedEdge;
use islands::{area, islands};
use left_out::LeftOut;
use raster::Polygon;
use room::{LayoutWatch, MAX_TEXELS};
use unwrap::{Request, Unwrapped, unwrap};

impl Atlas {
    /// Pages for all meshes of a scene whose shared edges are known.
    ///
    /// # Errors
    /// If pages are too small or texels too many, or if the model's own coordinates must be kept and cannot.
    pub(crate) fn build(
        scene: &Scene,
        edges: &[SharedEdge],
        left_out: &LeftOut,
        options: &BakeOptions,
        watch: LayoutWatch,
    ) -> Result<Self, Invalid> {
        if let Some(density) = options.density.filter(|density| !density.is_finite() || *density <= 0.0) {
            return Err(Invalid::new(
                format!("the density is {density} texels per unit"),
                "give a number greater than 0",
            ));
        }
        let sizes = BakeOptions::MIN_SIZE..=BakeOptions::MAX_SIZE;
        if !sizes.contains(&options.size) {
            let problem = format!("pages have {} texels a side", options.size);
            return Err(Invalid::new(problem, format!("give a size from {} to {}", sizes.start(), sizes.end())));
        }
        let mut atlas = Self { left_out: left_out.clone(), ..Self::default() };
        let requests = atlas.keep(scene, options)?;
        let Unwrapped { pages, parts, warning } =
            unwrap(scene, edges, left_out, &requests, options, atlas.pages.len(), watch)?;
        atlas.warnings.extend(warning);
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
        atlas.charts = islands(scene, &atlas.pages, &mut atlas.parts, left_out);
        if atlas.charts.is_empty() {
            return Err(Invalid::new("no triangle has an area", "give a model with surfaces"));
        }
        Ok(atlas)
    }

    /// The coordinates that the scene's meshes have, right or wrong, on one page; `None` if none has any or they are
    /// not to be used.
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
        if let Some(without) = receivers(scene).find(|&mesh| must && !has_own(mesh)) {
            return Err(Invalid::new(
                format!("{} has no second set of texture coordinates", mesh_name(scene, without)),
                "give it one, or leave --uv out",
            ));
        }
        if options.coordinates == Coordinates::New {
            return Ok(receivers(scene).map(|mesh| request(mesh, false)).collect());
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
        let others = receivers(scene).filter(|&mesh| is_shared || !usable[mesh]);
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
        given.charts = islands(scene, &given.pages, &mut given.parts, &LeftOut::default());
        Ok(given)
    }
}

/// The meshes that get light: all but lamps, which are not the model's.
fn receivers(scene: &Scene) -> impl Iterator<Item = usize> {
    (0..scene.meshes.len()).filter(|&mesh| !scene.meshes[mesh].is_added)
}

/// The meshes with lightmap coordinates.
fn own_coordinates(scene: &Scene) -> impl Iterator<Item = usize> {
    (0..scene.meshes.len()).filter(|&mesh| !scene.meshes[mesh].lightmap_texcoords.is_empty())
}

/// The size of a page on which parts have this density on average.
fn kept_size(scene: &Scene, parts: &[Part], density: f32) -> Result<u32, Invalid> {
    let unit = Page { width: 1, height: 1 };
    let (mut in_space, mut on_pages) = (0.0, 0.0);
    for part in parts {
        for (triangle, &face) in part.faces.iter().enumerate() {
            let on_page = Polygon::triangle(part.corners(triangle, unit)).area().abs();
            if on_page.is_finite() {
                on_pages += on_page;
                in_space += area(scene.meshes[part.mesh].corners(face as usize));
            }
        }
    }
    let size = if on_pages > 0.0 { f64::from(density) * (in_space / on_pages).sqrt() } else { 1.0 };
    if size > f64::from(BakeOptions::MAX_SIZE) {
        return Err(Invalid::new(
            format!("the model's own layout needs {size:.0} texels a side at {density} texels per unit"),
            format!("give a lower --density: a page has at most {} texels a side", BakeOptions::MAX_SIZE),
        ));
    }
    Ok((size.ceil() as u32).max(BakeOptions::MIN_SIZE))
}
