// hexrelief as a library: rectified pairs and disparity maps to compact, textured, metric meshes.
//
// Does for pictures and maps in memory what the command `hexrelief run` does for files, with the same keys,
// checks, messages and bytes; run.h does the same for files. Calls may come from any thread. They take turns,
// because each uses all the threads that it is given (run.threads). Views refer to the caller's memory, which
// is only read, and only during the call.
#pragma once

#include <hexrelief/error.h>
#include <hexrelief/version.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace hexrelief {
inline namespace v0 {

// Rows from the top, channels interleaved: 1 = grey, 3 = sRGB red green blue, and one more for alpha. Colours
// are not premultiplied by alpha; transparent pixels are unknown (input.mask.alpha). width = 0: no picture.
struct ImageView {
    const std::uint8_t* pixels = nullptr;
    int width = 0, height = 0, channels = 3;
    std::size_t row_bytes = 0;  // from one row to the next; 0 = no gaps between rows
};

// A map of the left view, rows from the top. The keys for files say how samples are read:
// - disparities, left(x, y) = right(x - d, y): floats are px; values that are not finite or not above 0 are
//   unknown. Integers are read by input.disparity.scale, offset_px and unknown; by default 16-bit integers
//   are 1/256 px.
// - depths: by default floats are metres along the optical axis and 16-bit integers millimetres;
//   input.depth may say otherwise.
// - confidences: pixels below input.confidence.threshold are unknown.
struct MapView {
    enum class Samples { float32, uint16, uint8 };
    const void* values = nullptr;
    int width = 0, height = 0;
    Samples samples = Samples::float32;
    std::size_t row_bytes = 0;  // as in ImageView
};

// A map of the left view, with its picture, mask and confidences.
struct MapInput {
    MapView disparity = {}, depth = {};  // exactly one of the two
    ImageView color = {};                // the left picture; without it there is no texture
    ImageView mask = {};                 // pixels that are 0 or transparent are unknown
    MapView confidence = {};
};

struct Picture {
    int width = 0, height = 0, channels = 3;
    std::vector<std::uint8_t> pixels;

    ImageView view() const { return {pixels.data(), width, height, channels}; }
};

struct Disparities {
    int width = 0, height = 0;
    std::vector<float> values;  // px, rows from the top; unknown is +infinity

    MapView view() const { return {values.data(), width, height}; }
};

// The rectified left camera and its distance to the right one. NaN = not given. A missing focal length is
// taken to be the picture's width, a missing baseline to be 1; if either is missing, the mesh is right
// only up to scale.
struct Camera {
    static constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();
    std::string file = {};  // as --calib: Middlebury, KITTI, OpenCV, ROS, ...; the values below override it
    double focal_px = kNotGiven;
    double baseline_m = kNotGiven;
    double cx = kNotGiven, cy = kNotGiven;  // px from the top left corner; the first pixel's centre is 0.5
    double doffs_px = kNotGiven;            // Z = focal_px * baseline_m / (disparity + doffs_px)
};

struct Options {
    // As --config: names of presets and YAML files, of which later ones win; empty = the defaults.
    std::vector<std::string> config = {};
    // As --set, in this order: {"density.background.fraction", "0.1"}. `hexrelief config
    // show` lists the keys.
    std::vector<std::pair<std::string, std::string>> settings = {};
    // Options of `hexrelief run` that set a key, applied after the settings: {"--seed", "7"}.
    // Messages name the option.
    std::vector<std::pair<std::string, std::string>> direct = {};
    // Callbacks run on the calling thread and must not call this library. Their exceptions end the work and
    // reach the caller.
    // progress: the current stage and the share of it that is done, beginning with 0.
    std::function<void(const std::string& stage, double share)> progress = {};
    std::function<void(const std::string& warning)> warn = {};
    // The lines of --verbose: a stage that has ended, and a decision.
    std::function<void(const std::string& stage, double seconds)> stage_ended = {};
    std::function<void(const std::string& decision)> decided = {};
};

// A mesh and everything that it was made from, so that it can be saved as often as needed. Pointers into it
// stay valid as long as it exists, also after a move.
class Mesh {
  public:
    Mesh(Mesh&&) noexcept;
    Mesh& operator=(Mesh&&) noexcept;
    ~Mesh();

    // Returns x y z of each vertex, in metres if is_metric(): the left camera is at the origin, +X right, +Y
    // up, and looks along -Z, as in glTF.
    const float* vertices() const;
    std::size_t vertex_count() const;
    // Returns the three vertices of each triangle, counter-clockwise as seen from the camera.
    const std::uint32_t* faces() const;
    std::size_t face_count() const;
    // Returns u v of each vertex: (0, 0) is the left picture's top left corner, (1, 1) its bottom right one.
    const float* uv() const;
    bool is_metric() const;

    // Return the lattice before it was cut and lifted: columns() x rows() vertices row by row, x y of each in
    // px of the left view; odd rows are shifted to the right by half a spacing.
    const float* lattice() const;
    int lattice_columns() const;
    int lattice_rows() const;
    // Returns the map that was meshed: filled where it was sparse, a rounded map's steps smoothed. Unknown is
    // +infinity.
    MapView disparity() const;

    // Returns the JSON text that --report writes. Each call takes the measures anew, which takes as long as a
    // part of the meshing. "outputs" lists the files that save() has written.
    std::string report() const;

    // Writes the mesh and its companion files, all or none. The extension gives the format. Settings
    // are keys of `export`, applied to this call only, on top of those that the mesh was made with.
    // Returns the files' paths.
    std::vector<std::string> save(const std::string& path, const Options& options = {}) const;

  private:
    friend Mesh mesh_input(const MapInput&, const Camera&, const Options&);
    struct State;
    explicit Mesh(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

// These functions throw Error with a message of one line; its kind is the exit code of the command line.

// Reads PNG, JPEG, TIFF, WebP, BMP, HEIC, PPM, PGM. Pixels are as stored, not turned by EXIF data.
Picture read_picture(const std::string& path);
// Reads any of the formats of maps (exporters/FORMATS.md), as the settings input.disparity say.
Disparities read_disparities(const std::string& path, const Options& options = {});

// Returns the disparities of the left picture of a rectified pair, at its size whatever
// disparity.working_px is. camera's file may give the range to search (ndisp).
Disparities compute_disparity(const ImageView& left, const ImageView& right, const Camera& camera = {},
                              const Options& options = {});

// Make a mesh from a map. A limit of budget.max_bytes applies to the bytes of a .glb. The setting run.backend
// picks the backend: auto, cpu or cuda.
Mesh mesh_input(const MapInput& input, const Camera& camera = {}, const Options& options = {});
Mesh mesh(const MapView& disparity, const ImageView& color = {}, const Camera& camera = {},
          const Options& options = {});

// Returns "0.2.0".
std::string version();

}  // namespace v0
}  // namespace hexrelief
