//! New texture coordinates, by the crate `uvunwrap`: charts grown by normals, flattened by least squares conformal maps
//! (Lévy et al. 2002) and packed by their shapes. The result does not depend on threads or the machine.
//!
//! Creases are borders of charts, for light changes abruptly there and a map's filter must not mix both sides. A mesh
//! stays on one page if it fits, as engines give a mesh one map.

use std::collections::HashMap;

use glam::{DVec3, Vec2, Vec3};
use uvunwrap::{Atlas, Density, Error, MeshInput, Options, Packing, Progress, Stage};

use super::atlas::{Layout, NO_CHART, Page, Part, Vertex, mesh_name};
use super::edges::SharedEdge;
use super::left_out::LeftOut;
use super::room::{LayoutStep, LayoutWatch, least_pages, many_pages, pieces};
use crate::bake::options::BakeOptions;
use crate::scene::Scene;
use crate::settings::Invalid;

/// A mesh that needs coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Request {
    pub(crate) mesh: usize,
    /// Whether the charts of its own coordinates get new places, instead of new charts.
    pub(crate) repack: bool,
}

/// With more triangles than these, packing by shape takes too long.
const MAX_TRIANGLES_BY_SHAPE: usize = 50_000;

/// Triangles with a height of less than this part of their mesh's diagonal have no chart.
const THINNEST: f64 = 1e-6;

/// The result of unwrapping.
#[derive(Default)]
pub(crate) struct Unwrapped {
    pub(crate) pages: Vec<Page>,
    pub(crate) parts: Vec<Part>,
    /// Warnings about the pages.
    pub(crate) warning: Option<String>,
}

/// Pages and parts for meshes; the pages will follow `first_page` others.
pub(crate) fn unwrap(
    scene: &Scene,
    edges: &[SharedEdge],
    left_out: &LeftOut,
    requests: &[Request],
    options: &BakeOptions,
    first_page: usize,
    watch: LayoutWatch,
) -> Result<Unwrapped, Invalid> {
    if requests.is_empty() {
        return Ok(Unwrapped::default());
    }
    let creases = creases(scene, edges);
    let geometry: Vec<_> = requests.iter().map(|request| Geometry::new(scene, *request, left_out)).collect();
    let inputs = |instances: &'static [f32]| -> Vec<MeshInput<'_>> {
        let inputs = requests.iter().zip(&geometry).map(|(request, geometry)| MeshInput {
            seams: (!request.repack).then_some(&creases[request.mesh][..]),
            ignored_faces: geometry.left_out,
            existing_uvs: request.repack.then_some(&geometry.coordinates[..]),
            // The crate cannot place a mesh without charts as a whole.
            instance_scales: if geometry.has_charts() { instances } else { &[] },
            ..MeshInput::new(&geometry.positions, &geometry.indices)
        });
        inputs.collect()
    };
    let triangles: usize = geometry.iter().map(|geometry| geometry.indices.len() / 3).sum();
    let pieces = requests.iter().zip(&geometry).map(|(request, geometry)| {
        let cuts = (!request.repack).then_some(&creases[request.mesh][..]);
        pieces(scene, request.mesh, geometry.which_have_charts(), cuts)
    });
    let charts = pieces.sum();
    watch(LayoutStep::Begin { triangles, charts, pages: least_pages(charts, options)? });
    let settings = Options {
        density: match options.density {
            None => Density::Auto { page_size: options.size },
            Some(texels_per_unit) => Density::Fixed { texels_per_unit, page_size: Some(options.size) },
        },
        padding: options.padding(),
        packing: if triangles > MAX_TRIANGLES_BY_SHAPE { Packing::Fast } else { Packing::Shape },
        ..Options::default()
    };
    // First each mesh in one piece; where one is too large for that, chart by chart.
    let generate = |instances: &'static [f32]| {
        let inputs = inputs(instances);
        let heard = |progress: Progress| {
            tell(watch, progress);
            true
        };
        caught(|| uvunwrap::generate_with_progress(&inputs, &settings, heard)).ok_or_else(|| {
            let fails = |number: &usize| caught(|| uvunwrap::generate(&inputs[*number..=*number], &settings)).is_none();
            let mesh = (0..inputs.len()).find(fails).map(|number| mesh_name(scene, requests[number].mesh));
            Invalid::new(
                format!("{} cannot be unwrapped: the unwrapper failed", mesh.as_deref().unwrap_or("the model")),
                "mend its triangles, or give it a second set of texture coordinates and bake with --uv keep",
            )
        })
    };
    let unwrapped = match generate(&[1.0])? {
        Err(Error::ChartTooLarge { .. }) => generate(&[])?,
        other => other,
    };
    let unwrapped = unwrapped.map_err(|error| explain(scene, requests, &error))?;
    let page = Page { width: unwrapped.width, height: unwrapped.height };
    let pages = vec![page; unwrapped.page_count as usize];
    let warning = many_pages(pages.len(), unwrapped.chart_count as usize, options);
    // Where nothing has a chart there is no page; any will do.
    let (pages, first_page) = match (pages.is_empty(), first_page) {
        (true, 0) => (vec![page], 0),
        (true, _) => (pages, 0),
        (false, _) => (pages, first_page),
    };
    let parts = requests.iter().enumerate();
    let parts = parts.flat_map(|(number, request)| split(*request, &unwrapped, number, first_page));
    Ok(Unwrapped { pages, parts: parts.collect(), warning })
}

/// Tells how far the crate is: finding charts counts as much as flattening them.
fn tell(watch: LayoutWatch, Progress { stage, done, total, .. }: Progress) {
    let part = total.map_or(0.0, |total| done as f32 / total.max(1) as f32);
    match stage {
        Stage::Segmenting => watch(LayoutStep::Unwrap(0.5 * part)),
        Stage::Parameterizing => watch(LayoutStep::Unwrap(0.5 + 0.5 * part)),
        Stage::Packing => watch(LayoutStep::Pack),
        _ => {}
    }
}

/// A mesh as the crate takes it.
struct Geometry<'a> {
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    coordinates: Vec<[f32; 2]>,
    /// Triangles that get no chart, if there are any.
    left_out: Option<&'a [bool]>,
}

impl<'a> Geometry<'a> {
    fn new(scene: &Scene, request: Request, left_out: &'a LeftOut) -> Self {
        let mesh = &scene.meshes[request.mesh];
        Self {
            positions: mesh.positions.iter().map(|position| position.to_array()).collect(),
            indices: mesh.triangles.iter().flatten().copied().collect(),
            coordinates: mesh.lightmap_texcoords.iter().map(|uv| uv.to_array()).collect(),
            left_out: left_out.of_mesh(request.mesh),
        }
    }

    /// Whether any triangle gets a chart.
    fn has_charts(&self) -> bool {
        (0..self.indices.len() / 3).any(self.which_have_charts())
    }

    /// Says of a triangle whether it gets a chart: the crate leaves out those that are thinner than the mesh is long by
    /// [`THINNEST`].
    fn which_have_charts(&self) -> impl Fn(usize) -> bool {
        let position = move |index: u32| Vec3::from(self.positions[index as usize]).as_dvec3();
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &position in &self.positions {
            let position = Vec3::from(position).as_dvec3();
            (low, high) = (low.min(position), high.max(position));
        }
        let thinnest = THINNEST * (high - low).length();
        let is_left_out = move |face: usize| self.left_out.is_some_and(|left_out| left_out[face]);
        move |face| {
            let [a, b, c] = [0, 1, 2].map(|corner| position(self.indices[3 * face + corner]));
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            !is_left_out(face) && (b - a).cross(c - a).length() / longest > thinnest
        }
    }
}

/// What `work` gives; `None` if it panics, as a crate may on unusual triangles.
fn caught<T>(work: impl FnOnce() -> T) -> Option<T> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(work)).ok()
}

/// Whether each side is a crease, by mesh and triangle.
fn creases(scene: &Scene, edges: &[SharedEdge]) -> Vec<Vec<[bool; 3]>> {
    let mut creases: Vec<Vec<[bool; 3]>> =
        scene.meshes.iter().map(|mesh| vec![[false; 3]; mesh.triangles.len()]).collect();
    for side in edges.iter().filter(|edge| !edge.is_smooth).flat_map(|edge| edge.sides) {
        creases[side.mesh as usize][side.face as usize][usize::from(side.side)] = true;
    }
    creases
}

/// The parts of a mesh: one for each page on which it has triangles.
fn split(request: Request, atlas: &Atlas, number: usize, first_page: usize) -> Vec<Part> {
    let mesh = &atlas.meshes[number];
    let rect = mesh.instances.first();
    let mut parts: Vec<Part> = Vec::new();
    // Where a vertex of the mesh is in a part.
    let mut places: HashMap<(usize, u32), u32> = HashMap::new();
    for (face, corners) in (0..).zip(mesh.indices.chunks_exact(3)) {
        let on_page = corners.iter().find_map(|&vertex| mesh.vertices[vertex as usize].page);
        let page = first_page + rect.map(|rect| rect.page).or(on_page).unwrap_or(0) as usize;
        let index = match parts.iter().position(|part| part.page == page) {
            Some(part) => part,
            None => {
                parts.push(Part {
                    mesh: request.mesh,
                    page,
                    vertices: Vec::new(),
                    triangles: Vec::new(),
                    faces: Vec::new(),
                    charts: Vec::new(),
                    layout: if request.repack { Layout::Repacked } else { Layout::Unwrapped },
                });
                parts.len() - 1
            }
        };
        let part = &mut parts[index];
        let triangle = [0, 1, 2].map(|corner| {
            *places.entry((index, corners[corner])).or_insert_with(|| {
                let vertex = mesh.vertices[corners[corner] as usize];
                let uv = Vec2::from(vertex.uv);
                let uv = rect.map_or(uv, |rect| {
                    let (min, max) = (Vec2::from(rect.min), Vec2::from(rect.max));
                    min + uv * (max - min)
                });
                part.vertices.push(Vertex { source: vertex.xref, uv });
                part.vertices.len() as u32 - 1
            })
        });
        part.triangles.push(triangle);
        part.faces.push(face);
        part.charts.push(NO_CHART);
    }
    parts
}

/// The remedy for an error of the crate.
fn explain(scene: &Scene, requests: &[Request], error: &Error) -> Invalid {
    match *error {
        Error::ChartTooLarge { width, height, page_size } => Invalid::new(
            format!("a chart needs {width}x{height} texels with its gutter, and a page has {page_size}x{page_size}"),
            "give a larger --size, a lower --density or a smaller --gutter",
        ),
        Error::AtlasTooLarge { texels } => Invalid::new(
            format!("the charts need {texels} texels"),
            "give a lower --density: the coordinates of the model may be in smaller units than metres",
        ),
        Error::NonFiniteUv { mesh, vertex } => Invalid::new(
            format!("vertex {vertex} of {} has no finite coordinates", mesh_name(scene, requests[mesh].mesh)),
            "leave --uv out for new ones",
        ),
        _ => Invalid::new(format!("no coordinates can be made: {error}"), "check --size, --density and --gutter"),
    }
}

#[cfg(test)]
mod tests {
    use halfdome_kernel::sampling::Stream;

    use super::*;
    use crate::bake::layout::atlas::Atlas as Pages;
    use crate::scene::{Material, Mesh};

    fn mesh(name: &str, positions: Vec<Vec3>) -> Mesh {
        let triangles = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Mesh { name: name.to_owned(), positions, triangles, ..Mesh::default() }
    }

    fn atlas(meshes: Vec<Mesh>) -> Result<Pages, Invalid> {
        let scene = Scene { meshes, materials: vec![Material::default()], ..Scene::default() };
        Pages::new(&scene, &BakeOptions { size: 64, ..BakeOptions::default() })
    }

    #[test]
    fn meshes_without_charts_take_no_others_with_them() {
        let good = || mesh("good", vec![Vec3::ZERO, Vec3::X, Vec3::Y]);
        let far = Vec3::splat(4.7e7);
        for bad in [
            vec![far, far + Vec3::X, far + Vec3::Y],
            vec![Vec3::ZERO; 3],
            vec![Vec3::ZERO, Vec3::X, 2.0 * Vec3::X],
            vec![Vec3::ZERO, Vec3::X, Vec3::new(0.5, 1e-9, 0.0)],
        ] {
            let both = atlas(vec![mesh("bad", bad.clone()), good()]).unwrap();
            assert_eq!((both.charts.len(), both.parts[both.charts[0].part].mesh), (1, 1), "{bad:?}");
            assert!(atlas(vec![mesh("bad", bad.clone())]).unwrap_err().problem.contains("area"), "{bad:?}");
        }
    }

    /// One to twenty triangles of any size, place and shape: charts or an error, but no panic.
    #[test]
    fn extreme_triangles_have_an_atlas_or_an_error() {
        for i in 0..300 {
            let random = |k: u32| Stream::new(17, i, k).uniform4(0);
            let [count, size, place, kind] = random(0);
            let count = 1 + (20.0 * count * count) as u32;
            let (size, place) = (10f32.powf(24.0 * size - 16.0), 10f32.powf(16.0 * place - 8.0));
            let positions = (0..3 * count).map(|k| {
                let [x, y, z, w] = random(k + 1);
                let flat = if kind < 0.3 { Vec3::new(1.0, 1e-7, 0.0) } else { Vec3::ONE };
                let step = if kind > 0.8 && w < 0.3 { Vec3::ZERO } else { Vec3::new(x, y, z) };
                (place * Vec3::splat(if kind < 0.5 { 1.0 } else { w }) + size * flat * step)
                    .clamp(Vec3::splat(-4e12), Vec3::splat(4e12))
            });
            let meshes = positions.collect::<Vec<_>>().chunks(9).map(|part| mesh("", part.to_vec())).collect();
            if let Err(error) = atlas(meshes) {
                assert!(!error.problem.contains("failed"), "{i}: {error}");
            }
        }
    }

    #[test]
    fn panics_are_caught() {
        assert_eq!(caught(|| 3), Some(3));
        assert_eq!(caught(|| -> i32 { panic!("as a crate may") }), None);
    }
}
