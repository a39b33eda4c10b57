// A run from files to files. The command `hexrelief run` calls this and prints what it returns.
#pragma once

#include <hexrelief/hexrelief.h>

#include <cstdint>
#include <string>
#include <vector>

namespace hexrelief {
inline namespace v0 {

// Paths, named as the command's options; empty = not given. The source is left and right, or stereo, which
// holds both, or disparity or depth, with or without color.
struct FileRequest {
    std::string left = {}, right = {}, stereo = {};
    std::string disparity = {}, depth = {}, color = {};
    std::string disparity_right = {}, color_right = {};  // of the right view, beside `disparity` and `color`
    std::string mask = {}, confidence = {};
    // The extension gives the format; "-" writes GLB to the standard output, "drc:-" another format.
    std::vector<std::string> outputs = {};
    std::string report = {};         // JSON
    std::string depfile = {};        // rule for make that lists all files read
    std::string stages_folder = {};  // for each stage's result and pictures
    // Does nothing if the report says that all outputs exist and were made from the same inputs and
    // configuration. Needs `report`, which gets a stamp for the next run.
    bool update = false;
    // Runs of this process, including this one: run.backend: auto chooses a device if all of them together
    // are worth its start.
    int runs = 1;
    // The process ends with this run: its device starts and is given back sooner. No other call of the
    // library may use the device, before or after the run.
    bool ends_process = false;
};

// The results of a run. Depths are metres if is_metric; shares are of the picture, 0..1.
struct RunSummary {
    bool is_up_to_date = false;  // FileRequest::update found nothing to do; all else is empty
    struct File {
        std::string path;
        std::uint64_t bytes = 0;
    };
    struct Budget {
        std::string kind = {};  // "vertices", "max_bytes" or "max_error_px"; empty = none
        double limit = 0, reached = 0;
        double spacing_px = 0, tolerance_px = 0;
        int solves = 0;
    };
    std::vector<File> outputs = {};
    int width = 0, height = 0;  // size of the left view as it was meshed, px
    int reduced_by = 1;  // px of its picture along each side of these px, above 1 if a large pair was reduced
    std::size_t vertices = 0, triangles = 0;
    double percent_cost = 0;  // how unequal the lattice's cells are
    double nearest = 0, farthest = 0;
    bool is_metric = false;
    std::string read_as = {};  // how a map's samples were read: "16-bit integers, mm"; empty without a map
    double meshed = 0, background = 0, unknown = 0, occluded = 0;
    std::string alignment = {};  // what was done to a pair whose rows were off; empty = nothing
    std::string camera = {};     // the camera that a photograph says itself; empty = it says none
    // Share of the known pixels that seemed farther than a matched scene's end, and were moved to that depth.
    double on_backdrop = 0, backdrop = 0;
    // Share of a pair's texture on which both views agree, in words: "good", "partly", "hardly"; empty
    // without a pair.
    std::string support = {};
    bool is_filled = false;  // true if a sparse map was filled between its measurements
    double measured = 0, filled = 0;
    bool lacks_color = false;  // true if an output could hold a texture, but there is no picture
    Budget budget = {};
    std::string backend = {}, device = {};  // "cpu" or "cuda"; make and model
    int threads = 0;
    std::size_t device_bytes = 0, peak_bytes = 0;  // largest use of the device's memory and of the process's
};

// Runs the whole job. Throws Error; then no new file remains.
RunSummary run(const FileRequest& files, const Options& options = {});

// Throws what run() would throw before it reads its input: for wrong options and configurations, for an
// output that is an input, and for a place that cannot be written.
void check_run(const FileRequest& files, const Options& options = {});

// True if an output or the report goes to the standard output, which should then receive nothing else.
bool uses_standard_output(const FileRequest& files);

// Return the names of the formats of images, and of maps, that are read: "PNG, JPEG, ...".
std::string image_formats();
std::string map_formats();

// Return the names that outputs may have: ".glb .gltf ..." are the extensions of files, "glb:-, drc:-, ..."
// send a format to the standard output.
std::string output_extensions();
std::string output_streams();

// Makes SIGINT, SIGTERM and SIGHUP, unless ignored, undo the files of the current run and end the
// process with exit code 130. Only for programs, not for libraries. Call this function before any
// other thread is started.
void end_on_interrupt();

}  // namespace v0
}  // namespace hexrelief
