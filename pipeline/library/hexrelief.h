// hexrelief as a library: rectified pairs and disparity maps to compact, textured, metric meshes.
//
// All that the command `hexrelief run` does of pictures and maps that are in memory, with the same keys,
// checks, messages and bytes; run.h does the same of files. Calls may come from any thread; they take turns,
// for each uses all the threads that it is given (run.threads). Views refer to the caller's memory, which is
// only read, and only during the call.
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

// Rows from the top, channels interleaved: 1 = grey, 3 = sRGB red green blue, and one more for alpha, which
// is not multiplied into the others: what is transparent is unknown (input.mask.alpha). width = 0: no
// picture.
struct ImageView {
    const std::uint8_t* pixels = nullptr;
    int width = 0, height = 0, channels = 3;
    std::size_t row_bytes = 0;  // from one row to the next; 0 = rows follow each other without gaps
};

// A map of the left view, rows from the top. Samples are read as those of files are, by the same keys:
// - disparities, left(x, y) = right(x - d, y): floats are px, and what is not above 0 or not finite is
//   unknown; of integers input.disparity.scale, offset_px and unknown say what they mean, and 16 bits are
//   1/256 px where they say nothing.
// - depths: floats are metres along the optical axis, 16-bit integers millimetres, where input.depth says
//   nothing else.
// - confidences: what is below input.confidence.threshold is unknown.
struct MapView {
    enum class Samples { float32, uint16, uint8 };
    const void* values = nullptr;
    int width = 0, height = 0;
    Samples samples = Samples::float32;
    std::size_t row_bytes = 0;  // as ImageView's
};

// What is known of the left view: disparities or depths, and what goes with them.
struct MapInput {
    MapView disparity = {}, depth = {};  // one of them
    ImageView color = {};                // the left picture; without pixels there is no texture
    ImageView mask = {};                 // what is 0 or transparent is unknown
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

// The rectified left camera and the distance of the two. NaN = not given. Without a focal length it is the
// picture's width, without a baseline that is 1, and the mesh is right up to scale alone.
struct Camera {
    static constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();
    std::string file = {};  // as --calib: Middlebury, KITTI, OpenCV, ROS, ...; the values below override it
    double focal_px = kNotGiven;
    double baseline_m = kNotGiven;
    double cx = kNotGiven, cy = kNotGiven;  // px from the top left corner; the first pixel's centre is 0.5
    double doffs_px = kNotGiven;            // Z = focal_px * baseline_m / (disparity + doffs_px)
};

struct Options {
    std::string config = {};  // as --config: a preset's name or a YAML file; empty = the defaults
    // As --set, in this order: {"density.background.fraction", "0.1"}. The keys are those that `hexrelief
    // config show` lists.
    std::vector<std::pair<std::string, std::string>> settings = {};
    // Options of `hexrelief run` that stand for a key, on top of the settings: {"--seed", "7"}. Messages name
    // the option.
    std::vector<std::pair<std::string, std::string>> direct = {};
    // All are called on the calling thread, and must not call this library. What they throw ends the work and
    // reaches the caller.
    // When a stage begins (0), and as far as it is done (..1).
    std::function<void(const std::string& stage, double share)> progress = {};
    std::function<void(const std::string& warning)> warn = {};
    // When a stage has ended, and what was decided: the lines of --verbose.
    std::function<void(const std::string& stage, double seconds)> stage_ended = {};
    std::function<void(const std::string& decision)> decided = {};
};

// A mesh with all that it was made from, so that it can be saved as often as needed. Pointers into it live as
// long as it does, also where it is moved.
class Mesh {
  public:
    Mesh(Mesh&&) noexcept;
    Mesh& operator=(Mesh&&) noexcept;
    ~Mesh();

    // x y z of each vertex, in metres where is_metric(): the left camera is at the origin, +X right, +Y up,
    // and looks along -Z, as in glTF.
    const float* vertices() const;
    std::size_t vertex_count() const;
    // Three vertices of each triangle, counter-clockwise seen from the camera.
    const std::uint32_t* faces() const;
    std::size_t face_count() const;
    // u v of each vertex: (0, 0) is the left picture's top left corner, (1, 1) its bottom right one.
    const float* uv() const;
    bool is_metric() const;

    // The lattice before it was cut and lifted: columns() x rows() vertices by rows, x y of each in px of the
    // left view; odd rows lie half a spacing to the right.
    const float* lattice() const;
    int lattice_columns() const;
    int lattice_rows() const;

    // What --report writes, as JSON; its measures are taken at each call and take as long as a part of the
    // meshing. "outputs" lists what save() has written.
    std::string report() const;

    // Writes the mesh, and the files that go with its format; all or none. The extension gives the format.
    // Settings are those of `export`, on top of those that the mesh was made with. Returns the files' paths.
    std::vector<std::string> save(const std::string& path, const Options& options = {}) const;

  private:
    friend Mesh mesh_input(const MapInput&, const Camera&, const Options&);
    struct State;
    explicit Mesh(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

// All of these throw Error with a message of one line; its kind is the exit code of the command line.

// PNG, JPEG, TIFF, WebP, PPM, PGM.
Picture read_picture(const std::string& path);
// PFM, PNG, PGM, TIFF, NPY, NPZ, EXR, as the settings input.disparity say.
Disparities read_disparities(const std::string& path, const Options& options = {});

// The disparities of the left picture of a rectified pair. camera's file may say the range to search (ndisp).
Disparities compute_disparity(const ImageView& left, const ImageView& right, const Camera& camera = {},
                              const Options& options = {});

// A limit of budget.max_bytes is one of the bytes of a .glb. The backend is the setting run.backend: auto,
// cpu or cuda.
Mesh mesh_input(const MapInput& input, const Camera& camera = {}, const Options& options = {});
Mesh mesh(const MapView& disparity, const ImageView& color = {}, const Camera& camera = {},
          const Options& options = {});

// "0.1.0"
std::string version();

}  // namespace v0
}  // namespace hexrelief
