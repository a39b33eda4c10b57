#include "pipeline/cli/tiles/tiles_commands.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <memory>
#include <thread>
#include <utility>

#include "pipeline/cli/terminal/printable.h"
#include "pipeline/data/error.h"
#include "pipeline/files/interrupt.h"
#include "pipeline/files/output_set.h"
#include "pipeline/readers/windows/map_writer.h"
#include "pipeline/readers/windows/terrain.h"

namespace hexrelief::cli {
namespace {

struct MakeMapOptions {
    std::string size;
    std::filesystem::path output;
    int seed = 1, threads = 0;
};

// Parses "WIDTHxHEIGHT"; the writer checks the sides.
std::pair<int, int> parse_map_size(const std::string& text) {
    int width = 0, height = 0;
    const char* const end = text.data() + text.size();
    const auto [x, failure] = std::from_chars(text.data(), end, width);
    if (failure == std::errc() && x != end && *x == 'x') {
        const auto [after, wrong] = std::from_chars(x + 1, end, height);
        if (wrong == std::errc() && after == end) return {width, height};
    }
    throw Error(ErrorKind::usage, "--size is '" + text + "'; give WIDTHxHEIGHT in px, such as 8192x8192");
}

int make_map(const MakeMapOptions& options) {
    const auto [width, height] = parse_map_size(options.size);
    files::check_writable_file(options.output);
    files::install_interrupt_handling();
    files::OutputSet outputs;
    outputs.place(options.output);
    readers::MapWriter writer(outputs.files(), options.output, width, height);
    const int all = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    readers::write_terrain(writer, width, height, static_cast<std::uint32_t>(options.seed),
                           options.threads > 0 ? options.threads : all);
    writer.finish();
    outputs.commit();
    std::printf("%s: %dx%d px\n", printable(options.output.string()).c_str(), width, height);
    end_telling();
    return 0;
}

}  // namespace

void add_make_map_command(Command& group) {
    Command command = group.add_command("make-map", "write a made-up disparity map of any size to try with");
    const auto options = std::make_shared<MakeMapOptions>();
    command.add_option("--size", &options->size, "of the map, px",
                       {.value = "WIDTHxHEIGHT", .required = true});
    command.add_option("--seed", &options->seed, "another number, another map",
                       {.shows_default = true, .range = {{0, 2147483647}}});
    command.add_option("-o,--output", &options->output, "map.tif (BigTIFF in tiles) or map.pfm",
                       {.value = "MAP", .required = true});
    command.add_option("--threads", &options->threads, "CPU threads; 0 = all",
                       {.shows_default = true, .range = {{0, 1024}}});
    command.set_footer(
        "Hills, cliffs, buildings with flat roofs, lakes without a disparity; 32-bit floats. The same size\n"
        "and seed are the same bytes on every machine.\n\n"
        "Example:\n"
        "  hexrelief tiles make-map --size 32768x32768 -o map.tif   (4 GiB)");
    command.set_action([options] { return make_map(*options); });
}

}  // namespace hexrelief::cli
