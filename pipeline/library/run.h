// A run from files to files. The command `hexrelief run` calls this and prints what it returns.
#pragma once

#include <hexrelief/hexrelief.h>

#include <cstdint>
#include <string>
#include <vector>

namespace hexrelief {
inline namespace v0 {

// Paths, by the names of the command's options; empty = not given. Either left and right, or stereo, which
// holds both, or disparity or depth, with color or without.
struct FileRequest {
    std::string left = {}, right = {}, stereo = {};
    std::string disparity = {}, depth = {}, color = {};
    std::string mask = {}, confidence = {};
    // The extension gives the format; "-" is the standard output, as GLB, and "drc:-" as what it says.
    std::vector<std::string> outputs = {};
    std::string report = {};         // JSON
    std::string depfile = {};        // a rule for make: the outputs depend on all files that are read
    std::string stages_folder = {};  // of each stage's result and pictures
    // Nothing is done where the report says that all outputs are there, of the same inputs and configuration.
    // It has to be named, and gets a stamp for the next time.
    bool update = false;
    // Runs that this process does, this one included: run.backend: auto takes a device where it is worth its
    // start for all of them.
    int runs = 1;
    // The process ends with this run: its device starts and is given back sooner. Nothing else of the library
    // may use the device then, before or after it.
    bool ends_process = false;
};

// What a run came to. Depths are metres where is_metric; shares are of the picture, 0..1.
struct RunSummary {
    bool is_up_to_date = false;  // FileRequest::update: there was nothing to do, and all else is empty
    struct File {
        std::string path;
        std::uint64_t bytes = 0;
    };
    struct Budget {
        std::string kind = {};  // "vertices", "max_bytes" or "max_error_px"; empty = there is none
        double limit = 0, reached = 0;
        double spacing_px = 0, tolerance_px = 0;
        int solves = 0;
    };
    std::vector<File> outputs = {};
    int width = 0, height = 0;  // of the left view, px
    std::size_t vertices = 0, triangles = 0;
    double percent_cost = 0;  // how unequal the lattice's cells are
    double nearest = 0, farthest = 0;
    bool is_metric = false;
    double meshed = 0, background = 0, unknown = 0, occluded = 0;
    bool is_filled = false;  // the map was sparse, and was filled between its measurements
    double measured = 0, filled = 0;
    bool lacks_color = false;  // an output could hold a texture, and there was no picture for it
    Budget budget = {};
    std::string backend = {}, device = {};  // "cpu" or "cuda"; its make and model
    int threads = 0;
    std::size_t device_bytes = 0, peak_bytes = 0;  // of memory: the device's, and the process's own
};

// Throws Error; then no new file is left behind.
RunSummary run(const FileRequest& files, const Options& options = {});

// Throws what run() would throw before it reads its input: for wrong options and configurations, an output
// that is an input, a place that cannot be written.
void check_run(const FileRequest& files, const Options& options = {});

// Whether an output or the report goes to the standard output, which should then hold nothing else.
bool uses_standard_output(const FileRequest& files);

// What outputs may be called: ".glb .gltf ..." are the extensions of files, "glb:-, drc:-, ..." send a format
// to the standard output.
std::string output_extensions();
std::string output_streams();

// For programs, not for libraries. From now on SIGINT, SIGTERM and SIGHUP (where not ignored) undo the files
// of the run at hand and end the process with exit code 130. Call it before any other thread is started.
void end_on_interrupt();

}  // namespace v0
}  // namespace hexrelief
