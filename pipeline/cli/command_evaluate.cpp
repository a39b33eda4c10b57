#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "pipeline/cli/commands.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/stages/disparity.h"

namespace hexrelief {
namespace {

struct MapOptions {
    std::optional<double> scale, offset_px, unknown;

    // Through the field table, which knows the ranges.
    DisparityFileConfig file_config(const std::string& prefix) const {
        Config config;
        if (scale) apply_option(config, prefix + "scale", "input.disparity.scale", shortest(*scale));
        if (offset_px)
            apply_option(config, prefix + "offset", "input.disparity.offset_px", shortest(*offset_px));
        if (unknown) apply_option(config, prefix + "unknown", "input.disparity.unknown", shortest(*unknown));
        return config.input.disparity;
    }
};

struct EvaluateOptions {
    std::string map, truth;
    MapOptions of_map, of_truth;
    bool json = false;
};

void add_map_options(Command& command, MapOptions& options, const std::string& prefix,
                     const std::string& whose) {
    command.add_option(prefix + "scale", &options.scale, whose + " samples divided by this are px",
                       {.value = "S"});
    command.add_option(prefix + "offset", &options.offset_px, "px added to " + whose + " disparities",
                       {.value = "O"});
    command.add_option(prefix + "unknown", &options.unknown, whose + " sample that means 'not known'",
                       {.value = "V"});
}

void print_json(const DisparityEvaluation& result) {
    nlohmann::ordered_json json;
    json["schema"] = 1;
    json["bad_0.5_percent"] = result.bad_percent[0];
    json["bad_1_percent"] = result.bad_percent[1];
    json["bad_2_percent"] = result.bad_percent[2];
    json["bad_4_percent"] = result.bad_percent[3];
    json["average_error_px"] = result.average_error_px;
    json["rms_error_px"] = result.rms_error_px;
    json["coverage_percent"] = result.coverage_percent;
    json["truth_pixels"] = result.truth_pixels;
    std::printf("%s\n", json.dump(2).c_str());
}

int evaluate(const EvaluateOptions& options) {
    const DisparityMap map = read_disparity_map(options.map, options.of_map.file_config("--"));
    const DisparityMap truth = read_disparity_map(options.truth, options.of_truth.file_config("--gt-"));
    const DisparityEvaluation result = evaluate_disparity(map, truth);
    if (options.json) {
        print_json(result);
        return 0;
    }
    for (int i = 0; i < 4; ++i)
        std::printf("bad-%-3g          %7.3f %%\n", kBadThresholds_px[i], result.bad_percent[i]);
    std::printf(
        "average error   %8.4f px\nrms error       %8.4f px\ncoverage         %7.3f %%\ntruth         %10lld "
        "px\n",
        result.average_error_px, result.rms_error_px, result.coverage_percent, result.truth_pixels);
    return 0;
}

}  // namespace

void add_evaluate_command(Command& program) {
    Command command = program.add_command("evaluate", "compare a disparity map with ground truth");
    const auto options = std::make_shared<EvaluateOptions>();
    command.add_option("DISP", &options->map, "disparity map", {.required = true});
    command.add_option("GT", &options->truth, "ground truth of the same size", {.required = true});
    add_map_options(command, options->of_map, "--", "the map's");
    add_map_options(command, options->of_truth, "--gt-", "the truth's");
    command.add_flag("--json", options->json, "as JSON");
    command.set_footer(
        "bad-T: percent of the truth's known pixels whose error is above T px or that the map does not "
        "know.\n"
        "Errors are over the pixels known in both; coverage is their share of the truth's.\n\n"
        "Examples:\n"
        "  hexrelief evaluate stages/disparity.pfm disp0GT.pfm\n"
        "  hexrelief evaluate stages/disparity.pfm disp2.png --gt-scale 4 --json");
    command.set_action([options] { return evaluate(*options); });
}

}  // namespace hexrelief
