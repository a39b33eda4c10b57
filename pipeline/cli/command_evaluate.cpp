#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "pipeline/cli/commands.h"
#include "pipeline/config/options.h"
#include "pipeline/evaluation/evaluate.h"
#include "pipeline/readers/disparity_reader.h"

namespace hexrelief::cli {
namespace {

struct MapOptions {
    std::string scale, offset_px, unknown;

    // The field table checks the ranges.
    readers::DisparityFileConfig file_config(const std::string& prefix) const {
        config::Config config;
        const auto take = [&](const char* option, const char* key, const std::string& text) {
            if (!text.empty())
                config::apply_option(config, prefix + option, std::string("input.disparity.") + key, text);
        };
        take("scale", "scale", scale);
        take("offset", "offset_px", offset_px);
        take("unknown", "unknown", unknown);
        config.input.disparity.scale_option = prefix + "scale";
        config.input.disparity.unknown_option = prefix + "unknown";
        return config.input.disparity;
    }
};

struct EvaluateOptions {
    std::string map, truth, right_truth;
    MapOptions of_map, of_truth;
    std::optional<double> discontinuity_px;
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

void print_text(const evaluation::DisparityEvaluation& result) {
    for (int i = 0; i < 4; ++i)
        std::printf("bad-%-3g          %7.3f %%\n", evaluation::kBadThresholds_px[i], result.bad_percent[i]);
    std::printf("average error   %8.4f px\n", result.average_error_px);
    std::printf("rms error       %8.4f px\n", result.rms_error_px);
    std::printf("coverage         %7.3f %%\n", result.coverage_percent);
    std::printf("truth         %10lld px\n", result.truth_pixels);
    std::printf("bad-1 nonocc.    %7.3f %%\n", result.bad_nonoccluded_percent[1]);
    std::printf("bad-2 nonocc.    %7.3f %%\n", result.bad_nonoccluded_percent[2]);
    std::printf("bad-2 of known   %7.3f %%\n", result.bad_known_percent[2]);
    std::printf("edge wrong       %7.3f %%\n", result.edge_wrong_percent);
    std::printf("edge unknown     %7.3f %%\n", result.edge_unknown_percent);
    std::printf("roughness       %8.4f px\n", result.roughness_px);
}

int evaluate(const EvaluateOptions& options) {
    const DisparityMap map = readers::read_disparity_map(options.map, options.of_map.file_config("--"));
    const readers::DisparityFileConfig of_truth = options.of_truth.file_config("--gt-");
    const DisparityMap truth = readers::read_disparity_map(options.truth, of_truth);
    evaluation::EvaluationConfig config;
    if (options.discontinuity_px) config.discontinuity_px = *options.discontinuity_px;
    DisparityMap right_truth;
    if (!options.right_truth.empty()) {
        right_truth = readers::read_disparity_map(options.right_truth, of_truth);
        config.right_truth = &right_truth;
    }
    const evaluation::DisparityEvaluation result = evaluation::evaluate_disparity(map, truth, config);
    nlohmann::ordered_json json = {{"schema", 1}};
    json.update(evaluation::evaluation_json(result));
    if (options.json)
        std::printf("%s\n", json.dump(2).c_str());
    else
        print_text(result);
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
    command.add_option("--gt-right", &options->right_truth,
                       "the right view's truth, read as the truth is; none: what the truth itself hides",
                       {.value = "FILE"});
    command.add_option(
        "--discontinuity", &options->discontinuity_px,
        "neighbours in the truth that differ by more are an edge (1; 2 suits full-size scenes)",
        {.value = "PX"});
    command.add_flag("--json", options->json, "as JSON");
    command.set_footer(
        R"(bad-T: percent of the truth's known pixels whose error is above T px or that the map does not know.
Errors are over the pixels known in both; coverage is their share of the truth's.
nonocc.: of the pixels that the right view sees as well. of known: of the pixels known in both.
edge: of the pixels within 3 px of a true discontinuity, those nearer to the wrong side of it, and those
that the map does not know.
roughness: RMS against the local plane on slanted planes of the truth; a deviation counts 2 px at most.
A disparity of 0 counts as unknown. With --json there are the numbers of pixels as well.

Examples:
  hexrelief evaluate stages/disparity.pfm disp0GT.pfm
  hexrelief evaluate stages/disparity.pfm disp2.png --gt-scale 4 --json
  hexrelief evaluate stages/disparity.pfm disp2.png --gt-right disp6.png --gt-scale 4)");
    command.set_action([options] { return evaluate(*options); });
}

}  // namespace hexrelief::cli
