//! The kernel's gather against scenes whose irradiance and derivatives are known exactly. Nothing is traced: each scene
//! finds by formula what is along a direction.

mod figures;
mod hessian;
mod polygons;
mod scene;
mod symmetry;
