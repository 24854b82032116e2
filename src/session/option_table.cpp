#include "session/option_table.h"

namespace parhelion {

namespace {

constexpr uint32_t kRender = command_bit(Command::Render);
constexpr uint32_t kView = command_bit(Command::View);
constexpr uint32_t kDraw = kRender | kView;
constexpr uint32_t kCompare = command_bit(Command::Compare);
constexpr uint32_t kMerge = command_bit(Command::Merge);
constexpr uint32_t kDevices = command_bit(Command::Devices);
constexpr uint32_t kInfo = command_bit(Command::Info);
constexpr uint32_t kExport = command_bit(Command::Export);
constexpr uint32_t kBench = command_bit(Command::Bench);
constexpr uint32_t kSettings = command_bit(Command::Settings);
constexpr uint32_t kHelp = command_bit(Command::Help);
constexpr uint32_t kTakesScene = kDraw | kInfo | kExport;

constexpr std::string_view kUseSpp = "use --spp N: a path tracer adds samples to one picture";
constexpr std::string_view kUseFrames = "use --frames N: the realtime renderer makes frames";
constexpr std::string_view kPathTracersOnly = "leave it out: only the path tracers have it";
constexpr std::string_view kRealtimeOnly = "leave it out: only --renderer realtime has it";
constexpr uint32_t kLength = 1, kViewpoint = 2;  // exclusive groups

// A row of a few lines each, with the fields that it needs.
// clang-format off
const OptionSpec kOptions[] = {
    // The picture
    {.name = "--renderer", .section = "Picture", .commands = kDraw, .kind = ValueKind::Choice, .value = "NAME", .fallback = "reference",
     .help = "how light is computed", .choices = "reference|wavefront|realtime"},
    {.name = "--size", .section = "Picture", .commands = kDraw, .kind = ValueKind::Size, .value = "WxH", .fallback = "1280x720",
     .help = "width and height of the picture in pixels"},
    {.name = "--seed", .section = "Picture", .commands = kDraw, .kind = ValueKind::Integer, .value = "S", .fallback = "0",
     .help = "another seed gives another, equally good, pattern of noise", .max = 4294967295.0},
    {.name = "--spp", .section = "Picture", .commands = kRender, .kind = ValueKind::Integer, .value = "N", .fallback = "64",
     .help = "samples per pixel", .min = 1, .max = 1 << 30, .renderers = kPathTracers, .instead = kUseFrames, .exclusive = kLength},
    {.name = "--spp", .section = "Picture", .commands = kView, .kind = ValueKind::Integer, .value = "N",
     .help = "samples per pixel after which a picture is finished (default: none, it gets better and better)", .min = 1, .max = 1 << 30},
    {.name = "--spp-range", .section = "Picture", .commands = kRender, .kind = ValueKind::Range, .value = "A-B",
     .help = "only the samples A <= index < B (multiples of 64): writes a part for `parhelion merge`", .bits = kNotInPreset,
     .renderers = kPathTracers, .instead = kUseFrames, .exclusive = kLength},
    {.name = "--frames", .section = "Picture", .commands = kRender, .kind = ValueKind::CountOrRange, .value = "N|A-B",
     .help = "number of frames, or a range of them, for --out NAME.####.exr (realtime: also for its last one alone; default 64)"},
    {.name = "--time-budget", .section = "Picture", .commands = kRender, .kind = ValueKind::Duration, .value = "TIME",
     .help = "stop after this time (30s, 5m, 1h) and write what is finished", .bits = kNotInPreset},
    {.name = "--max-bounces", .section = "Picture", .commands = kDraw, .kind = ValueKind::Integer, .value = "N", .fallback = "16",
     .help = "how often a path may scatter: 1 is direct light only, 0 is unlimited", .max = 65535},
    {.name = "--pixel-filter", .section = "Picture", .commands = kDraw, .kind = ValueKind::Choice, .value = "NAME", .fallback = "box",
     .help = "box: rays spread over the pixel; point: all through its centre", .choices = "box|point", .renderers = kPathTracers,
     .instead = "leave it out: the realtime renderer looks through the centres of pixels"},
    {.name = "--exposure", .section = "Picture", .commands = kDraw, .kind = ValueKind::Number, .value = "EV|scene", .fallback = "scene",
     .help = "EV100 of the PNG; scene: metered by a small probe, printed and recorded", .choices = "scene", .min = -32, .max = 32},
    {.name = "--tonemap", .section = "Picture", .commands = kDraw | kMerge, .kind = ValueKind::Choice, .value = "NAME", .fallback = "agx",
     .help = "tone curve of the PNG", .choices = "agx|aces|linear"},
    {.name = "--denoise", .section = "Picture", .commands = kDraw, .kind = ValueKind::Choice, .value = "NAME", .fallback = "none",
     .help = "remove noise: builtin, of the realtime renderer's frames, with those before them; oidn, of every picture that is shown or "
             "written, by Open Image Denoise 2 (PARHELION_OIDN)",
     .choices = "none|builtin|oidn"},
    {.name = "--upscale", .section = "Picture", .commands = kDraw, .kind = ValueKind::Number, .value = "X", .fallback = "1",
     .help = "trace frames that are smaller by this factor each way, up to 3, and put the picture's pixels together over time; needs --denoise builtin",
     .min = 1, .max = 3, .renderers = kRealtime, .instead = kRealtimeOnly},
    {.name = "--average", .section = "Picture", .commands = kRender, .help = "write the mean of all frames after the warm-up",
     .renderers = kRealtime, .instead = kUseSpp},
    {.name = "--warmup", .section = "Picture", .commands = kRender, .kind = ValueKind::Integer, .value = "N",
     .help = "frames before the first that --average counts (default 64)", .max = 1 << 20, .renderers = kRealtime, .instead = kUseSpp},
    {.name = "--preroll", .section = "Picture", .commands = kRender, .kind = ValueKind::Integer, .value = "N",
     .help = "draw only N frames before the first of a sequence that is written, instead of all from frame 0 on: sooner, and somewhat other pictures",
     .max = 1 << 20, .renderers = kRealtime, .instead = "leave it out: a path tracer's frames do not lean on those before them"},

    // Camera and time
    {.name = "--camera", .section = "Camera and time", .commands = kDraw, .kind = ValueKind::Text, .value = "NAME|INDEX",
     .help = "a camera of the scene (default: its first; without any, one that frames the scene)", .exclusive = kViewpoint},
    {.name = "--look-from", .section = "Camera and time", .commands = kDraw, .kind = ValueKind::Vector, .value = "x,y,z",
     .help = "a camera of your own: its position in metres", .exclusive = kViewpoint},
    {.name = "--look-at", .section = "Camera and time", .commands = kDraw, .kind = ValueKind::Vector, .value = "x,y,z",
     .help = "the point that --look-from looks at (default: the middle of the scene)"},
    {.name = "--fov", .section = "Camera and time", .commands = kDraw, .kind = ValueKind::Number, .value = "DEG",
     .help = "vertical field of view in degrees", .min = 0.1, .max = 175},
    {.name = "--ortho-height", .section = "Camera and time", .commands = kDraw, .kind = ValueKind::Number, .value = "METRES",
     .help = "make the camera of --look-from orthographic: so much is in its picture from top to bottom", .min = 1e-6, .max = 1e9},
    {.name = "--fps", .section = "Camera and time", .commands = kRender, .kind = ValueKind::Number, .value = "F",
     .help = "frames per second of the scene's clock; 0, the default, holds time", .min = 0, .max = 1e6},
    {.name = "--camera-path", .section = "Camera and time", .commands = kDraw, .kind = ValueKind::File, .value = "F.json",
     .help = "a camera that moves along the keys of a file (docs/camera.md); --time says where on it", .exclusive = kViewpoint},
    {.name = "--aperture-radius", .section = "Camera and time", .commands = kDraw, .kind = ValueKind::Number, .value = "METRES",
     .fallback = "0", .help = "radius of a thin lens: what lies before or behind its focus blurs; 0 is a pinhole", .max = 1e3},
    {.name = "--focus-distance", .section = "Camera and time", .commands = kDraw, .kind = ValueKind::Number, .value = "METRES",
     .help = "depth at which the lens is sharp (default: of what lies in the picture's middle)", .min = 1e-6, .max = 1e9},
    {.name = "--shutter", .section = "Camera and time", .commands = kRender, .kind = ValueKind::Number, .value = "SECONDS", .fallback = "0",
     .help = "how long the shutter stays open from --time on: camera, objects and lights move meanwhile", .max = 1e6,
     .renderers = kPathTracers, .instead = "leave it out: the realtime renderer's frames are moments"},

    // Scene
    {.name = "--time", .section = "Scene", .commands = kTakesScene, .kind = ValueKind::Number, .value = "T", .fallback = "0",
     .help = "seconds on the scene's clock: where its animations stand", .min = 0, .max = 1e6},
    {.name = "--animation", .section = "Scene", .commands = kDraw | kInfo, .kind = ValueKind::Text, .value = "NAME|INDEX",
     .help = "the animation of a glTF file to play (default: all that do not move the same things, the first winning)"},
    {.name = "--animate", .section = "Scene", .commands = kTakesScene, .kind = ValueKind::Text, .value = "NAME",
     .help = "the scripted edit of a built-in scene to play (`parhelion info` lists them)"},
    {.name = "--variant", .section = "Scene", .commands = kTakesScene, .kind = ValueKind::Text, .value = "NAME",
     .help = "the material variant of a glTF file to show (`parhelion info` lists them)"},
    {.name = "--triangles", .section = "Scene", .commands = kTakesScene, .kind = ValueKind::Integer, .value = "N",
     .help = "about how many triangles builtin:forest or builtin:room has", .min = 1, .max = 2e9},
    {.name = "--allow-external", .section = "Scene", .commands = kTakesScene,
     .help = "let the scene read files outside its own folder"},

    // Light
    {.name = "--env", .section = "Light", .commands = kDraw, .kind = ValueKind::File, .value = "F.hdr|sky",
     .help = "light from an equirectangular picture (.hdr, .exr) in nits, or from a clear sky with its sun (sky.* of --set)"},
    {.name = "--env-intensity", .section = "Light", .commands = kDraw, .kind = ValueKind::Number, .value = "X", .fallback = "1",
     .help = "factor on the environment's light", .min = 0, .max = 1e9},
    {.name = "--env-rotation", .section = "Light", .commands = kDraw, .kind = ValueKind::Number, .value = "DEG", .fallback = "0",
     .help = "turns the environment about the vertical", .min = -36000, .max = 36000},
    {.name = "--no-default-light", .section = "Light", .commands = kDraw, .help = "keep a scene without any light black"},

    // Output
    {.name = "--out", .section = "Output", .commands = kRender | kMerge, .kind = ValueKind::File, .value = "F.exr|F.png",
     .help = "where the picture goes; give it again for a second format", .bits = kRepeats | kNotInPreset},
    {.name = "--out", .section = "Output", .commands = kExport, .kind = ValueKind::File, .value = "F.glb|F.gltf",
     .help = "where the scene goes; F.gltf brings F.bin and its images, named F-..., along", .bits = kNotInPreset},
    {.name = "--out", .section = "Output", .commands = kView, .kind = ValueKind::File, .value = "F.exr|F.png",
     .help = "where the key P writes the picture; give it again for a second format (default: SCENE-1.png, SCENE-2.png, ... here)",
     .bits = kRepeats | kNotInPreset},
    {.name = "--exr-type", .section = "Output", .commands = kDraw | kMerge, .kind = ValueKind::Choice, .value = "TYPE",
     .fallback = "half",
     .help = "numbers in the EXR", .choices = "half|float"},
    {.name = "--aov", .section = "Picture", .commands = kView, .kind = ValueKind::List, .value = "NAME",
     .help = "show a layer instead of the picture",
     .choices = "albedo|normal|emission|roughness|path.emission|path.direct_diffuse|path.direct_specular|path.indirect_diffuse|"
                "path.indirect_specular|path.transmission|debug.cells|debug.irradiance|debug.level|debug.count|debug.age|debug.life|debug.light|debug.rays|debug.duplicates"},
    {.name = "--aov", .section = "Output", .commands = kRender, .kind = ValueKind::List, .value = "LIST",
     .help = "further layers of the EXR, separated by commas; path.* and debug.* (realtime) stand for all of a group; noisy is the picture "
             "before --denoise oidn, reconstruction what --denoise builtin gets (realtime)",
     .choices = "albedo|normal|emission|roughness|depth|ids|motion|variance|noisy|reconstruction|path.emission|path.direct_diffuse|path.direct_specular|"
                "path.indirect_diffuse|path.indirect_specular|path.transmission|"
                "debug.cells|debug.irradiance|debug.level|debug.count|debug.age|debug.life|debug.light|debug.rays|debug.duplicates"},
    {.name = "--dataset", .section = "Output", .commands = kRender, .kind = ValueKind::File, .value = "DIR",
     .help = "write what training a reconstruction needs of every frame: what it gets, and a reference (docs/reconstruction.md); the same "
             "command goes on with a folder that it began",
     .bits = kNotInPreset, .renderers = kRealtime, .instead = "add --renderer realtime: its frames are what is reconstructed"},
    {.name = "--reference-spp", .section = "Output", .commands = kRender, .kind = ValueKind::Integer, .value = "N",
     .help = "samples per pixel of the references of --dataset (default 1024)", .min = 1, .max = 1 << 30, .renderers = kRealtime, .instead = kUseSpp},
    {.name = "--checkpoint", .section = "Output", .commands = kRender, .kind = ValueKind::File, .value = "F",
     .help = "save the state of the render here from time to time", .bits = kNotInPreset, .renderers = kPathTracers,
     .instead = kPathTracersOnly},
    {.name = "--checkpoint-every", .section = "Output", .commands = kRender, .kind = ValueKind::Duration, .value = "TIME",
     .fallback = "60s",
     .help = "time between two checkpoints", .bits = kNotInPreset, .renderers = kPathTracers, .instead = kPathTracersOnly},
    {.name = "--resume", .section = "Output", .commands = kRender,
     .help = "continue from the file of --checkpoint if it is there; with --frames, keep the frames that the same command has written",
     .bits = kNotInPreset},
    {.name = "--json", .section = "Output", .commands = kRender | kMerge | kExport | kBench, .kind = ValueKind::File, .value = "F",
     .help = "write the numbers of the run as JSON; - is stdout", .bits = kNotInPreset},
    {.name = "--json", .section = "Output", .commands = kCompare | kDevices | kInfo | kSettings, .kind = ValueKind::File, .value = "F",
     .help = "print JSON; --json=F writes it to a file", .bits = kNotInPreset | kOptionalValue},
    {.name = "--list-frame", .section = "Output", .commands = kRender,
     .help = "print the passes of the frame with reads, writes and GPU times, and what the wavefront did bounce by bounce",
     .bits = kNotInPreset},

    // Window
    {.name = "--present", .section = "Window", .commands = kView, .kind = ValueKind::Choice, .value = "MODE", .fallback = "fifo",
     .help = "fifo waits for the display, so that nothing tears; mailbox draws as fast as it can", .choices = "fifo|mailbox"},
    {.name = "--script", .section = "Window", .commands = kView, .kind = ValueKind::Text, .value = "STEP,STEP,...",
     .help = "do this by itself, then close: spp=N, frames=N and reference=N wait; size=WxH, renderer=NAME, layer=NAME, image=NAME, camera=NAME, orbit=DEG, "
             "time=T, play=on|off, set=KEY=VALUE, preset=NAME|FILE, denoise=NAME, split=0..1|off, panels=on|off, drop=FILE, reload, shaders, device=NAME, lose (the device) act as the "
             "panels do; pick=X:Y and copy print what they find, focus=X:Y looks at a point, report tells how frames came, shot=F.png writes the window as it is; save",
     .bits = kNotInPreset},

    // Device and settings
    {.name = "--trace", .section = "Device and settings", .commands = kDraw, .kind = ValueKind::Choice, .value = "WAY",
     .fallback = "auto",
     .help = "how rays are traced: ray tracing pipeline, ray queries, or our own BVH", .choices = "auto|pipeline|query|compute"},
    {.name = "--device", .section = "Device and settings", .commands = kDraw | kBench, .kind = ValueKind::Text, .value = "NAME|INDEX",
     .help = "a device of `parhelion devices` (default: the best)", .environment = "PARHELION_DEVICE"},
    {.name = "--validate", .section = "Device and settings", .commands = kDraw,
     .help = "run under the Vulkan validation layers; a message is a failure",
     .bits = kNotInPreset},
    {.name = "--set", .section = "Device and settings", .commands = kDraw | kBench, .kind = ValueKind::Assignment,
     .value = "group.field=value",
     .help = "change one of the settings that `parhelion settings` lists", .bits = kRepeats},
    {.name = "--preset", .section = "Device and settings", .commands = kDraw, .kind = ValueKind::File, .value = "F.json",
     .help = "take options from a file; environment and options win over it", .bits = kNotInPreset},
    {.name = "--print-settings", .section = "Device and settings", .commands = kRender,
     .help = "print all options as they would be used, in the form of a preset, and end", .bits = kNotInPreset},

    // compare
    {.name = "--layer", .section = "What is compared", .commands = kCompare, .kind = ValueKind::Text, .value = "NAME",
     .help = "a layer of the EXRs instead of the picture: albedo, path.direct_diffuse, ..."},
    {.name = "--html", .section = "Output", .commands = kCompare, .kind = ValueKind::File, .value = "DIR",
     .help = "write a report with both pictures and the FLIP map into this folder"},
    {.name = "--max-flip", .section = "Limits", .commands = kCompare, .kind = ValueKind::Number, .value = "X",
     .help = "exit with 4 if the mean FLIP error is larger", .min = 0, .max = 1},
    {.name = "--max-relmse", .section = "Limits", .commands = kCompare, .kind = ValueKind::Number, .value = "X",
     .help = "exit with 4 if the relative mean squared error is larger", .min = 0, .max = 1e12},

    // devices
    {.name = "--require", .section = "Options", .commands = kDevices, .help = "say what Parhelion needs of a device, and exit "
    "with 3 unless one has it all; the list says what each lacks"},
    {.name = "--measure", .section = "Options", .commands = kDevices,
     .help = "measure every way to trace on each device, and keep what is fastest for --trace auto, which itself never measures"},

    // bench
    {.name = "--scene", .section = "What runs", .commands = kBench, .kind = ValueKind::Text, .value = "SCENE",
     .help = "a scene instead of the suite's; may be given again", .bits = kRepeats},
    {.name = "--also", .section = "What runs", .commands = kBench, .kind = ValueKind::Text, .value = "SCENE",
     .help = "a scene besides those; may be given again", .bits = kRepeats},
    {.name = "--trace", .section = "What runs", .commands = kBench, .kind = ValueKind::Choice, .value = "WAY",
     .help = "one way to trace instead of all that the device has; may be given again", .choices = "pipeline|query|compute",
     .bits = kRepeats},
    {.name = "--size", .section = "What runs", .commands = kBench, .kind = ValueKind::Size, .value = "WxH",
     .help = "size of the pictures (default: the suite's)"},
    {.name = "--spp", .section = "What runs", .commands = kBench, .kind = ValueKind::Integer, .value = "N",
     .help = "samples per pixel (default: the suite's)", .min = 1, .max = 1 << 20},
    {.name = "--denoise", .section = "What runs", .commands = kBench, .kind = ValueKind::Choice, .value = "NAME", .fallback = "none",
     .help = "bench realtime: with what makes clean pictures of its frames", .choices = "none|builtin"},
    {.name = "--upscale", .section = "What runs", .commands = kBench, .kind = ValueKind::Number, .value = "X", .fallback = "1",
     .help = "bench realtime --denoise builtin: frames that are smaller by this factor each way, up to 3", .min = 1, .max = 3},
    {.name = "--layouts", .section = "What runs", .commands = kBench,
     .help = "bench trace: our own BVH in each of its node layouts, not only in that of trace.bvh"},
    {.name = "--baseline", .section = "Output", .commands = kBench, .kind = ValueKind::File, .value = "F.json",
     .help = "compare with the JSON of an earlier run"},

    // help
    {.name = "--man", .section = "Options", .commands = kHelp, .help = "print the man page (roff)"},
    {.name = "--completions", .section = "Options", .commands = kHelp, .kind = ValueKind::Choice, .value = "SHELL",
     .help = "print the completions of a shell", .choices = "bash|zsh|fish"},
    {.name = "--markdown", .section = "Options", .commands = kHelp, .help = "print docs/command-line.md"},
};

const CommandSpec kCommands[] = {
    {Command::Render, "render", "SCENE", 1, 1, "draw a scene",
     "SCENE is a .gltf or .glb file or a built-in scene such as builtin:cornell. A scene without a camera gets one that frames it; a scene "
     "without any light gets a sky, and the program says so.\n\nEXR files hold light in nits before exposure; PNG files are exposed "
     "and tone mapped. Files appear whole or not at all. The same command on the same device, driver and way to trace gives identical "
     "files.",
     {"parhelion render builtin:cornell --out cornell.png",
      "parhelion render scene.glb --env sky.hdr --size 1920x1080 --spp 256 --out a.exr --out a.png",
      "parhelion render scene.glb --look-from 3,2,5 --look-at 0,1,0 --fov 40 --out a.png",
      "parhelion render scene.glb --spp-range 0-512 --out part0.exr --json part0.json",
      "parhelion render builtin:diorama --animate robot --frames 120 --fps 30 --spp 64 --out robot.####.png",
      "parhelion render scene.glb --spp 4096 --checkpoint a.state --resume --out a.exr",
      "parhelion render builtin:cornell --set sampler.kind=pcg --out a.exr"}},
    {Command::View, "view", "SCENE [ENVIRONMENT]", 1, 2, "look at a scene in a window",
     "The program parhelion-view, which `parhelion view` starts. The scene comes in while the window already reacts; the picture gets better while "
     "nothing moves. F1 shows the keys. SCENE and the options are those of render where they make sense; ENVIRONMENT is that of --env.",
     {"parhelion view builtin:diorama", "parhelion view scene.glb sky.hdr --renderer wavefront",
      "parhelion view builtin:cornell --script spp=16,save --out cornell.png"}},
    {Command::Compare, "compare", "TEST REFERENCE", 2, 2, "measure how far a picture is from its reference",
     "Prints mean ratio, MSE, relative MSE, PSNR, SSIM and FLIP of TEST against REFERENCE. Both are exposed with the exposure "
     "recorded in the reference, or metered from it if it records none. F.####.exr stands for a numbered sequence, compared frame by "
     "frame: a limit holds for every frame, and a frame that only one side has is an error. With a limit, broken pixels (NaN, "
     "infinite) are over it.",
     {"parhelion compare test.exr reference.exr", "parhelion compare test.exr reference.exr --max-flip 0.05 --html report",
      "parhelion compare 'a.####.exr' 'b.####.exr' --json"}},
    {Command::Merge, "merge", "PART...", 1, 100000, "join the parts of `render --spp-range` into one picture",
     "The result is identical, bit for bit, to the picture that one run with all samples writes. Parts may be given in any order. "
     "Parts that overlap, leave a gap or were made with different settings are refused.",
     {"parhelion merge part0.exr part1.exr --out whole.exr --out whole.png"}},
    {Command::Devices, "devices", "", 0, 0, "list the Vulkan devices and what each can do",
     "--trace auto takes what a table of device classes says, unless --measure has measured this device with this driver. What it found lies in "
     "the cache folder (PARHELION_CACHE_DIR, trace/*.json); remove the file and the table counts again. A picture depends on it only through "
     "the way to trace, which the JSON of render names with its source (option, measured, table).",
     {"parhelion devices", "parhelion devices --measure", "parhelion devices --require", "parhelion devices --json"}},
    {Command::Info, "info", "SCENE", 1, 1, "say what is in a scene", "",
     {"parhelion info scene.glb", "parhelion info builtin:cornell --json"}},
    {Command::Export, "export", "SCENE", 1, 1, "write a scene as glTF 2.0",
     "Writes all that the scene holds: geometry, materials and images as they were read, to the last bit, so that the file draws the same "
     "picture. A glTF file is written at rest with its animations, skins and morph targets, and is not moved by --time; a built-in scene as it "
     "stands at --time of --animate. glTF has no environment: --env lights the file again. The program warns of what is left out.\n\n"
     "Files appear whole or not at all. F.gltf is written with F.bin and one F-NAME.png (.jpg, ...) an image beside it; files of these names "
     "that are there already are replaced only together with F.gltf.",
     {"parhelion export builtin:cornell --out cornell.glb", "parhelion export scene.glb --out folder/scene.gltf",
      "parhelion export builtin:spheres --out spheres.glb --json numbers.json"}},
    {Command::Bench, "bench", "[SUITE]", 0, 1, "measure speed: scenes x renderers x ways to trace",
     "SUITE is quick (default), full, replay (which share of a pass its rays alone take), reference (the path tracer on large "
     "scenes, shading in raygen and in closest-hit shaders), wavefront (that with 8 bounces beside the wavefront in each of its forms, with its occupancy and "
     "which share of Extend's and Connect's time their rays alone take), realtime (passes of the realtime renderer while the camera turns; --spp: frames), or trace (millions of primary, diffuse and shadow rays a second by each way to "
     "trace when a pass does nothing else, in rooms of 10,368, 249,600 and 1,997,568 triangles as one mesh and as instances: room-s, room-m, "
     "room-l, room-s-instanced, ...). Prints a table, and JSON with --json. "
     "Compare numbers of one device only.",
     {"parhelion bench", "parhelion bench full --json now.json --baseline before.json",
      "parhelion bench --scene scene.glb --trace compute", "parhelion bench reference --also a.glb --also b.glb --json reference.json",
      "parhelion bench wavefront --also a.glb --also b.glb --json wavefront.json", "parhelion bench trace --scene room-m --layouts"}},
    {Command::Settings, "settings", "", 0, 0, "list every setting of --set with its range and default", "", {"parhelion settings"}},
    {Command::Help, "help", "[COMMAND]", 0, 1, "explain a command", "",
     {"parhelion help render", "parhelion help --man > parhelion.1",
      "parhelion help --completions bash > /etc/bash_completion.d/parhelion"}},
};
// clang-format on

constexpr NamedHelp kExitCodes[] = {
    {"0", "done"},
    {"1", "failed: a file, the scene or the device"},
    {"2", "wrong usage"},
    {"3", "the device lacks something needed; the message says what"},
    {"4", "a comparison exceeded its limit"},
    {"130", "interrupted by Ctrl-C; what was finished is written"},
    {"143", "terminated; what was finished is written"},
};

constexpr NamedHelp kEnvironment[] = {
    {"PARHELION_DEVICE", "device, as --device"},
    {"PARHELION_LOG", "trace, debug, info (default), warn, error or off"},
    {"PARHELION_CACHE_DIR", "folder of the pipeline caches and of what devices --measure found (default: the user's cache folder)"},
    {"PARHELION_OIDN", "the library of --denoise oidn (default: libOpenImageDenoise.so.2, where the system looks for libraries)"},
    {"NO_COLOR", "no colours on the terminal"},
    {"PARHELION_MASK", "for tests: what devices are taken not to have, a list: pipeline and query (ways to trace), raster, draw_count (draws of a counted length)"},
    {"PARHELION_SHADER_DIR", "a folder with a shaders.pack that replaces the embedded one; the viewer reads it again when it changes"},
    {"PARHELION_SHADER_BUILD", "a line for the shell that makes that pack anew: what the viewer's key F6 runs"},
};

}  // namespace

std::span<const CommandSpec> command_table() { return kCommands; }
std::span<const OptionSpec> option_table() { return kOptions; }
std::span<const NamedHelp> exit_code_table() { return kExitCodes; }
std::span<const NamedHelp> environment_table() { return kEnvironment; }

}  // namespace parhelion
