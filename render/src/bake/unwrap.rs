//! New texture coordinates, by the crate `uvunwrap`: charts grown by normals, flattened by least squares conformal maps
//! (Lévy et al. 2002) and packed by their shapes. The result does not depend on threads or the machine.
//!
//! Creases are borders of charts, for light changes abruptly there and a map's filter must not mix both sides. A mesh stays on
//! one page if it fits, as engines give a mesh one map.

use std::collections::HashMap;

use glam::Vec2;
use uvunwrap::{Atlas, Density, Error, MeshInput, Options, Packing};

use super::atlas::{Layout, NO_CHART, Page, Part, Vertex, mesh_name};
use super::edges::SharedEdge;
use super::options::BakeOptions;
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
const MANY_TRIANGLES: usize = 50_000;

/// Pages and parts for meshes; the pages will follow `first_page` others.
pub(crate) fn unwrap(
    scene: &Scene,
    edges: &[SharedEdge],
    requests: &[Request],
    options: &BakeOptions,
    first_page: usize,
) -> Result<(Vec<Page>, Vec<Part>), Invalid> {
    if requests.is_empty() {
        return Ok((Vec::new(), Vec::new()));
    }
    let creases = creases(scene, edges);
    let geometry: Vec<_> = requests.iter().map(|request| Geometry::new(scene, *request)).collect();
    let inputs = |instances: &'static [f32]| -> Vec<MeshInput<'_>> {
        let inputs = requests.iter().zip(&geometry).map(|(request, geometry)| MeshInput {
            seams: (!request.repack).then_some(&creases[request.mesh][..]),
            existing_uvs: request.repack.then_some(&geometry.coordinates[..]),
            instance_scales: instances,
            ..MeshInput::new(&geometry.positions, &geometry.indices)
        });
        inputs.collect()
    };
    let triangles: usize = geometry.iter().map(|geometry| geometry.indices.len() / 3).sum();
    let settings = Options {
        density: match options.density {
            None => Density::Auto { page_size: options.size },
            Some(texels_per_unit) => Density::Fixed { texels_per_unit, page_size: Some(options.size) },
        },
        padding: options.padding(),
        packing: if triangles > MANY_TRIANGLES { Packing::Fast } else { Packing::Shape },
        ..Options::default()
    };
    // First each mesh in one piece; where one is too large for that, chart by chart.
    let unwrapped = match uvunwrap::generate(&inputs(&[1.0]), &settings) {
        Err(Error::ChartTooLarge { .. }) => uvunwrap::generate(&inputs(&[]), &settings),
        other => other,
    };
    let unwrapped = unwrapped.map_err(|error| explain(scene, requests, &error))?;
    let page = Page { width: unwrapped.width, height: unwrapped.height };
    let pages = vec![page; unwrapped.page_count as usize];
    let parts = requests.iter().enumerate();
    let parts = parts.flat_map(|(number, request)| split(*request, &unwrapped, number, first_page));
    Ok((pages, parts.collect()))
}

/// A mesh as the crate takes it.
struct Geometry {
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
    coordinates: Vec<[f32; 2]>,
}

impl Geometry {
    fn new(scene: &Scene, request: Request) -> Self {
        let mesh = &scene.meshes[request.mesh];
        Self {
            positions: mesh.positions.iter().map(|position| position.to_array()).collect(),
            indices: mesh.triangles.iter().flatten().copied().collect(),
            coordinates: mesh.lightmap_texcoords.iter().map(|uv| uv.to_array()).collect(),
        }
    }
}

/// For each mesh and triangle, which sides are creases.
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

/// What to do about an error of the crate.
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
