//! What help says after the options.

/// What the codes mean.
pub(super) const EXIT_CODES: &str = "\
Exit codes:
  0  done
  1  bad input or usage, found before the render
  2  the system failed, for example while the picture was written
  3  interrupted (Ctrl-C, SIGTERM); the picture so far is written, or the state from which `bake --resume` goes on;
     `cubemap`, `probes` and `irradiance` write nothing
  5  an experiment of `halfdome validate` failed, or a check of `halfdome bake --check-uv`
  A second Ctrl-C ends the program at once, with 130 and no picture.";

/// Of the program.
pub(super) const EXAMPLES: &str = "\
Examples:
  halfdome                              the built-in Cornell box, with 32 samples per pixel
  halfdome render room.glb              a model, to room.exr and room.png
  halfdome render room.toml --spp 1024  a scene file, with more samples
  halfdome info room.glb --json         what is in a model";

/// Of `halfdome render`.
pub(super) const RENDER_EXAMPLES: &str = "\
Examples:
  halfdome render cornell --size 256x256 --spp 16 -o small.png
  halfdome render hall.obj --eye 0,1.7,4 --target 0,1,0 --sky 0.5,0.6,0.8
  halfdome render hall.toml --integrator normals -o normals.exr
  halfdome render hall.glb --exposure -1 --tone reinhard --progress none

Options win over the scene file, the scene file over the model. With both --eye and --target the camera is a new \
one; with one of them the model's camera is changed. A model without a camera is seen from 30 degrees to the right of \
its front and 20 above, from where all of it is in the picture.";

/// Of `halfdome bake`.
pub(super) const BAKE_EXAMPLES: &str = "\
Examples:
  halfdome bake level.glb -o level.baked.glb --preset bevy --density 16
  halfdome bake level.glb -o level.baked.glb --preset three --sky 0.5 --report report.html
  halfdome bake room.obj -o room.baked.obj --mode ao --ao-distance 2
  halfdome bake level.glb --check-uv=charts.png

Texels lie on the fronts of surfaces. A bake whose level, options and files are unchanged does nothing.";

/// Of `halfdome cubemap`.
pub(super) const CUBEMAP_EXAMPLES: &str = "\
Examples:
  halfdome cubemap studio.hdr -o studio.ktx2 --diffuse              for Bevy's EnvironmentMapLight: both of its maps
  halfdome cubemap room.glb --at 0,1.5,0 -o room.ktx2 --spp 1024    what a point of a scene sees
  halfdome cubemap sky --daylight 30,90 -o day.exr -o day.png       a clear sky, unfolded
  halfdome cubemap studio.hdr -o studio.hdr --axes three            six faces for three.js, which filters them itself
  halfdome cubemap studio.hdr -o s.ktx2 --seams lookup --print-lookup wgsl

Faces are in KTX2's order (+X, -X, +Y, -Y, +Z, -Z) and turned as Vulkan and Direct3D have them. A map depends on source, \
options and seed alone. An interrupted run writes nothing.";

/// Of `halfdome probes`.
pub(super) const PROBES_EXAMPLES: &str = "\
Examples:
  halfdome probes level.glb --grid 16x4x16 -o level.ktx2 -o level.json   for Bevy's IrradianceVolume, with its transform
  halfdome probes level.glb --grid 4x4x4 --min -2,0,-2 --max 2,4,2 -o room.exr
  halfdome probes level.glb --points seats.txt -o seats.json

A probe that is inside of something is moved to a free point of its cell, or filled from its neighbours; its state says so. \
Probes depend on scene, options and seed alone. An interrupted run writes nothing.";

/// Of `halfdome validate`.
pub(super) const VALIDATE_EXAMPLES: &str = "\
Examples:
  halfdome validate                       all experiments, in some 5 minutes
  halfdome validate furnace lights-sky    a family, and a single experiment
  halfdome validate --plots figures       with figures (SVG) and their points (CSV)
  halfdome validate --quick --json        for programs; one line has name, quantity, measured, expected, tolerance, pass";
