//! The peers' trees over one scene.

#[cfg(feature = "peers")]
use std::convert::Infallible;
use std::fmt::Display;
use std::time::Instant;

use halfdome_benches::tracer::Tracer;
use halfdome_kernel::Triangle;

use crate::embree::Embree;
#[cfg(feature = "peers")]
use crate::obvhs::Obvhs;
#[cfg(all(feature = "peers", target_feature = "avx2"))]
use crate::tinybvh::Tinybvh;

/// What a ray tracer other than ours has built.
pub(crate) trait Peer {
    /// Memory of the tree in bytes, if it says.
    fn bytes(&self) -> Option<usize>;

    /// The methods of tracing it, by name; `coherent` says that neighbouring rays run alike.
    fn tracers(&self, coherent: bool) -> Vec<(&'static str, Box<dyn Tracer + '_>)>;
}

/// A peer's tree over a scene.
pub(crate) struct Tree<'a> {
    /// The peer.
    pub(crate) name: &'static str,
    /// How long it took to build, on one thread.
    pub(crate) seconds: f64,
    /// The tree.
    pub(crate) peer: Box<dyn Peer + 'a>,
}

impl<'a> Tree<'a> {
    fn build<P: Peer + 'a, E: Display>(
        name: &'static str,
        build: impl FnOnce() -> Result<P, E>,
    ) -> Result<Self, String> {
        let start = Instant::now();
        let peer = build().map_err(|error| format!("{name}: {error}"))?;
        Ok(Self { name, seconds: start.elapsed().as_secs_f64(), peer: Box::new(peer) })
    }
}

/// Builds the trees of all peers that are here, in the best quality each has.
///
/// # Errors
/// If a peer cannot build its tree.
pub(crate) fn build<'a>(triangles: &[Triangle], embree: Option<&'a Embree>) -> Result<Vec<Tree<'a>>, String> {
    let mut trees = Vec::new();
    if let Some(embree) = embree {
        trees.push(Tree::build("embree", || embree.build(triangles))?);
    }
    #[cfg(all(feature = "peers", target_feature = "avx2"))]
    trees.push(Tree::build("tinybvh", || Tinybvh::build(triangles))?);
    #[cfg(feature = "peers")]
    trees.push(Tree::build("obvhs", || Ok::<_, Infallible>(Obvhs::build(triangles)))?);
    Ok(trees)
}

/// What is missing of the peers from the registry in this build, and how to have it.
pub(crate) fn missing() -> Option<&'static str> {
    if !cfg!(feature = "peers") {
        Some("no tinybvh and obvhs: build with --features peers to have them")
    } else if !cfg!(target_feature = "avx2") {
        Some("no tinybvh: its Rust binding wants AVX2 at compile time, as with RUSTFLAGS=\"-C target-cpu=native\"")
    } else {
        None
    }
}
