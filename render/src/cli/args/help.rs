//! The help text after the options.

/// The meanings of exit codes.
pub(crate) const EXIT_CODES: &str = "\
Exit codes:
  0  done
  1  bad input or usage; nothing is written
  2  the system failed, for example while writing a file; `view` has no
     display, or was built without its window
  3  interrupted (Ctrl-C, SIGTERM): `render` writes the picture so far
     (of --frames without --checkpoint or --resume only those that are
     done), `bake` the state for --resume; `cubemap`, `denoise`,
     `probes` and `irradiance` write nothing
  4  `render` ended at a limit before its target: --time before all
     samples, or --spp or --time before the error of --noise; the picture
     is written
  5  an experiment of `validate` or a check of `bake --check-uv` failed
  A second Ctrl-C ends the program at once, with code 130 and no picture.";

/// Examples of the program.
pub(crate) const EXAMPLES: &str = "\
Examples:
  halfdome                              render the built-in Cornell box
  halfdome render room.glb              a model, to room.exr and room.png
  halfdome render room.toml --spp 1024  a scene file, with more samples
  halfdome info room.glb                the contents of a model
  halfdome bake level.glb -o level.baked.glb --preset three";

/// Examples of `halfdome render`.
pub(crate) const RENDER_EXAMPLES: &str = "\
Examples:
  halfdome render cornell --size 256x256 --spp 16 -o small.png
  halfdome render hall.obj --eye 0,1.7,4 --target 0,1,0 --sky 0.5,0.6,0.8
  halfdome render hall.toml --integrator normals -o normals.exr
  halfdome render hall.glb --exposure -1 --tone reinhard --progress none
  halfdome render hall.glb --f-number 2.8 --focus 3 --blades 6
  halfdome render hall.glb --camera panorama --ipd 64 -o hall.png
  halfdome render hall.glb --noise 2% --spp 65536 --checkpoint --resume
  halfdome render hall.glb --spp 16 --denoise nlm

Options override the scene file, and the scene file overrides the model. --eye and --target together make a new camera; \
one of them changes the model's camera.";

/// Examples of `halfdome view`.
pub(crate) const VIEW_EXAMPLES: &str = "\
Examples:
  halfdome view room.glb --sky 0.5
  halfdome view hall.toml --size 960x540 --spp 1024 --tone neutral
  halfdome view hall.glb --lpe indirect='C<RD>.+[LOB]' --light-groups

The picture is that of `halfdome render` with the same options. h shows keys and mouse. s saves the camera in the scene \
file, or in a new one beside a model: hall.toml beside hall.glb. Without a display the exit code is 2. The window is in \
programs that are built with it: cargo install --path render --features view.";

/// Examples of `halfdome denoise`.
pub(crate) const DENOISE_EXAMPLES: &str = "\
Examples:
  halfdome render hall.glb --aov --aov-through -o noisy.exr
  halfdome denoise noisy.exr -o clean.exr -o clean.png
  halfdome denoise noisy.exr -o clean.exr --with nlm

Albedo, normals (--aov) and, for nlm, the halves that --aov writes too are read from the picture. Open Image Denoise is \
found by OIDN_LIB=/path/libOpenImageDenoise.so, or where it is usually installed. An interrupted run writes nothing.";

/// Examples of `halfdome merge`.
pub(crate) const MERGE_EXAMPLES: &str = "\
Examples:
  halfdome render hall.glb --spp 4096 --shard 1/2 -o part1.hdf     on one machine
  halfdome render hall.glb --spp 4096 --shard 2/2 -o part2.hdf     on another
  halfdome merge part1.hdf part2.hdf -o hall.exr -o hall.png
  halfdome merge part1.state part2.state -o level.baked.glb.state  of `halfdome bake --shard`
  halfdome merge part1.txt part2.txt -o irradiance.txt             of `halfdome irradiance --shard`

The picture is that of a single run, byte for byte, but for the time that is noted in it; so are bakes and irradiance.";

/// Examples of `halfdome bake`.
pub(crate) const BAKE_EXAMPLES: &str = "\
Examples:
  halfdome bake level.glb -o level.baked.glb --preset bevy --density 16
  halfdome bake level.glb -o level.baked.glb --preset three --sky 0.5 --report report.html
  halfdome bake room.obj -o room.baked.obj --mode ao --ao-distance 2
  halfdome bake level.glb --check-uv=charts.png
  halfdome bake level.glb --shard 1/2 -o part1.state               on one machine, 2/2 on another; then
  halfdome merge part1.state part2.state -o level.baked.glb.state
  halfdome bake level.glb --resume -o level.baked.glb

Texels lie on the front sides of surfaces. A bake does nothing if model, options and files are unchanged.";

/// Examples of `halfdome cubemap`.
pub(crate) const CUBEMAP_EXAMPLES: &str = "\
Examples:
  halfdome cubemap studio.hdr -o studio.ktx2 --diffuse
      both maps of Bevy's EnvironmentMapLight
  halfdome cubemap room.glb --at 0,1.5,0 -o room.ktx2 --spp 1024
      the view from a point in a scene
  halfdome cubemap sky --daylight 30,90 -o day.exr -o day.png
      a clear sky, unfolded
  halfdome cubemap studio.hdr -o studio.hdr --axes three
      six faces for three.js, which filters them itself
  halfdome cubemap studio.hdr -o s.ktx2 --seams lookup --print-lookup wgsl
      a map without seams, and the shader code to look it up

Faces are in KTX2's order (+X, -X, +Y, -Y, +Z, -Z) and oriented as in Vulkan and Direct3D. A map depends only on source, \
options and seed. An interrupted run writes nothing.";

/// Examples of `halfdome probes`.
pub(crate) const PROBES_EXAMPLES: &str = "\
Examples:
  halfdome probes level.glb --grid 16x4x16 -o level.ktx2 -o level.json
      for Bevy's IrradianceVolume, with its transform
  halfdome probes level.glb --grid 4x4x4 --min -2,0,-2 --max 2,4,2 -o room.exr
  halfdome probes level.glb --points seats.txt -o seats.json

A probe inside of an object is moved to a free point of its cell, or filled from its neighbours; its state says so. \
Probes depend only on scene, options and seed. An interrupted run writes nothing.";

/// Examples of `halfdome validate`.
pub(crate) const VALIDATE_EXAMPLES: &str = "\
Examples:
  halfdome validate                     all experiments, about 7 minutes on two cores
  halfdome validate furnace lights-sky  a family, and a single experiment
  halfdome validate --plots figures     with figures (SVG) and data (CSV)
  halfdome validate --quick --json      one line of JSON per experiment";
