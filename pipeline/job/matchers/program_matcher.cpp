#include "pipeline/job/matchers/program_matcher.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "exporters/images/image_writer.h"
#include "pipeline/config/options.h"
#include "pipeline/data/disparity_map.h"
#include "pipeline/data/error.h"
#include "pipeline/data/module.h"
#include "pipeline/data/number_text.h"
#include "pipeline/files/interrupt.h"
#include "pipeline/job/maps/disparity_input.h"
#include "pipeline/readers/depth/mask_reader.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/parse_text.h"
#include "pipeline/stages/other_views/other_view.h"

namespace hexrelief::job {
namespace {

constexpr int kSamples = 100;            // along each side
constexpr int kLargestDifference = 40;   // of two levels: beyond it the pixels are just different
constexpr double kClearlyBetter = 0.75;  // of the difference

int level_at(const Image& image, int x, int y) {
    const std::uint8_t* const pixel = image.at(x, y);
    int sum = 0;
    for (int c = 0; c < image.channels; ++c) sum += pixel[c];
    return sum / image.channels;
}

// Returns the mean difference of a sample of pixels from those that they match, if all disparities are
// multiplied by `factor`. A match outside the picture counts as different.
double difference(const DisparityMap& map, const StereoPair& pair, double factor) {
    long long sum = 0, count = 0;
    for (int row = 0; row < kSamples; ++row)
        for (int column = 0; column < kSamples; ++column) {
            const int x = column * map.width / kSamples, y = row * map.height / kSamples;
            const float d = map.at(x, y);
            if (!DisparityMap::known(d)) continue;
            const long match = std::lround(x - factor * d);
            const bool is_inside = match >= 0 && match < map.width;
            sum += is_inside ? std::min(kLargestDifference,
                                        std::abs(level_at(pair.left, x, y) -
                                                 level_at(pair.right, static_cast<int>(match), y)))
                             : kLargestDifference;
            ++count;
        }
    return count == 0 ? kLargestDifference : static_cast<double>(sum) / static_cast<double>(count);
}

void resize(DisparityMap& map, int width, int height) {
    DisparityMap resized{width, height, {}};
    resized.values.reserve(static_cast<std::size_t>(width) * height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            resized.values.push_back(
                map.at(static_cast<int>(static_cast<long long>(x) * map.width / width),
                       static_cast<int>(static_cast<long long>(y) * map.height / height)));
    map = std::move(resized);
}

// Changes the map, if necessary, so that it has the left picture's size and left(x, y) = right(x - d, y): it
// is brought to that size, its disparities with it, and the sign is turned, if that fits the pictures clearly
// better by a sample of pixels. Returns what was done; empty = nothing. Throws Error(input) if the map has
// another shape than the pictures.
std::string fit_answer(DisparityMap& map, const StereoPair& pair) {
    const int width = pair.left.width, height = pair.left.height;
    std::string told = fit_to_picture(map, width, height);
    const double by = static_cast<double>(width) / map.width;
    if (std::abs(by * map.height - height) > by + 1)
        throw Error(ErrorKind::input, "the map is " + size_text(map.width, map.height) +
                                          ", the pictures are " + size_text(width, height) +
                                          ": their shapes differ");
    if (map.width != width || map.height != height) {
        told += (told.empty() ? "" : "; ") +
                ("the map's " + size_text(map.width, map.height) + " px are brought to ") +
                size_text(width, height);
        resize(map, width, height);
    }
    // The likeliest first: the disparities are in px of the map, with the sign of the left view.
    const std::array<double, 4> factors{by, 1, -by, -1};
    double best = factors[0], least = difference(map, pair, best);
    for (const double factor : factors)
        if (const double other = difference(map, pair, factor); other < kClearlyBetter * least)
            best = factor, least = other;
    if (best == 1) return told;
    for (float& d : map.values)
        if (DisparityMap::known(d)) d = static_cast<float>(d * best);
    if (best < 0)
        told += std::string(told.empty() ? "" : "; ") + "its disparities have the other sign, and are turned";
    return told;
}

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr double kMostUnknown = 0.01;  // of a dense map

// Returns the words with their placeholders filled in. {out.EXT} is a map of another format than PFM, and so
// is {confidence.EXT}.
std::string filled_in(std::string word, const std::map<std::string, std::string>& values,
                      const std::map<std::string, fs::path*>& written) {
    for (const auto& [name, value] : values)
        for (std::size_t at = 0; (at = word.find(name, at)) != std::string::npos; at += value.size())
            word.replace(at, name.size(), value);
    for (const auto& [name, path] : written) {
        const std::size_t at = word.find(name);
        const std::size_t end = at == std::string::npos ? at : word.find('}', at);
        if (end == std::string::npos) continue;
        const std::string extension = word.substr(at + name.size(), end - at - name.size());
        if (!extension.empty()) path->replace_extension(extension);
        word.replace(at, end + 1 - at, path->string());
    }
    return word;
}

// Checks a worker's answer: {"ok": true}, or {"error": "..."}. Returns it. name: what messages begin with.
Json checked_answer(const std::string& line, const std::string& name, bool is_own) {
    Json json = Json::parse(line, nullptr, false);
    if (!json.is_object() || (!json.contains("ok") && !json.contains("error")))
        throw Error(ErrorKind::input,
                    name + ": the answer " + readers::codec::excerpt(line) +
                        R"( is not {"ok": true} or {"error": "..."}; what is printed for people )"
                        "belongs to the error stream");
    if (!json.contains("error")) return json;
    const Json& error = json.at("error");
    const std::string text = error.is_string() ? error.get<std::string>() : error.dump();
    if (is_own) throw Error(json.value("usage", false) ? ErrorKind::usage : ErrorKind::input, text);
    throw Error(ErrorKind::input, name + ": the pair was not matched: " + readers::codec::excerpt(text));
}

// Returns the words of the project's own worker for networks.
std::vector<std::string> words_for_network(const stages::DisparityConfig& config, int threads) {
    const ModulePlace own = find_module("hexrelief-onnx");
    if (own.path.empty())
        throw Error(ErrorKind::input,
                    "disparity.method=onnx: " + own.failure +
                        "; build hexrelief with libopencv-dnn-dev or ONNX Runtime installed, or match by "
                        "disparity.worker");
    return {own.path.string(), config.model, config.model_kind, std::to_string(threads)};
}

// Returns the picture moved to the left by `by` px, its border repeated: disparities grow by as much.
Image moved_left(const Image& image, int by) {
    Image moved = image;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            std::copy_n(image.at(std::clamp(x + by, 0, image.width - 1), y), image.channels, moved.at(x, y));
    return moved;
}

}  // namespace

// What a program is told of a pair; the names are those of its placeholders and of its requests.
struct ProgramMatcher::Question {
    fs::path left, right, out, confidence;
    int ndisp;
};

std::vector<std::string> ProgramMatcher::ask_worker(const Question& question,
                                                    const stages::DisparityConfig& range, int threads) {
    const bool is_network = range.method == stages::DisparityMethod::onnx;
    const std::vector<std::string> words =
        is_network ? words_for_network(range, threads) : config::words_of_line(range.worker);
    const std::string name = is_network ? "disparity.model: " + range.model + ": hexrelief-onnx"
                                        : "disparity.worker: " + readers::codec::excerpt(words.at(0));
    if (!worker_ || words != words_) worker_ = std::make_unique<ChildProgram>(words_ = words, name);
    // Whatever fails, the next pair gets a new worker.
    std::unique_ptr<ChildProgram> asked = std::move(worker_);
    asked->write_line(Json{
        {"left", question.left.string()},
        {"right", question.right.string()},
        {"out", question.out.string()},
        {"confidence", question.confidence.string()},
        {"ndisp",
         question.ndisp}}.dump(-1, ' ', false, Json::error_handler_t::replace));
    const Json json = checked_answer(asked->read_line(range.timeout_s), name, is_network);
    worker_ = std::move(asked);
    return json.value("told", std::vector<std::string>());
}

DisparityMap ProgramMatcher::answer(const StereoPair& pair, const std::string& view,
                                    const stages::DisparityConfig& range, int threads, bool& is_dense,
                                    RunLog& log) {
    const files::TemporaryFolder folder;
    Question question{folder.path() / "left.png", folder.path() / "right.png",
                      folder.path() / "disparity.pfm", folder.path() / "confidence.pfm",
                      range.num_disparities_px};
    exporters::write_png(question.left, pair.left);
    exporters::write_png(question.right, pair.right);
    if (range.method == stages::DisparityMethod::onnx || range.command.empty()) {
        const std::vector<std::string> told = ask_worker(question, range, threads);
        if (view == "left")
            for (const std::string& done : told) log.decide("disparity: " + done);
    } else {
        std::vector<std::string> words = config::words_of_line(range.command);
        for (std::string& word : words)
            word = filled_in(word,
                             {{"{left}", question.left.string()},
                              {"{right}", question.right.string()},
                              {"{ndisp}", std::to_string(question.ndisp)}},
                             {{"{out", &question.out}, {"{confidence", &question.confidence}});
        ChildProgram(words, "disparity.command: " + readers::codec::excerpt(words.at(0)))
            .finish(range.timeout_s);
    }
    std::error_code ignored;
    if (!fs::exists(question.out, ignored))
        throw Error(ErrorKind::input,
                    "disparity.method=command: the program ended well but wrote no map to the file "
                    "that {out} names");
    readers::DisparityFileConfig as_written;
    as_written.beyond_px = -readers::kLargestDisparity_px;  // the sign is looked at below
    DisparityMap map = readers::read_disparity_map(question.out, as_written);
    const std::string told = fit_answer(map, pair);
    if (!told.empty()) log.decide("disparity: the program's map of the " + view + " view: " + told);
    const auto unknown = std::ranges::count_if(map.values, [](float d) { return !DisparityMap::known(d); });
    is_dense &= static_cast<double>(unknown) <= kMostUnknown * static_cast<double>(map.values.size());
    if (fs::exists(question.confidence, ignored)) {
        const readers::PixelMask sure =
            readers::read_confidence(question.confidence, {range.least_confidence});
        hide(map.values, readers::resampled(sure, map.width, map.height));
        log.decide("disparity: the program is sure of " + percent_text(sure, 1) + " % of the " + view +
                   " view");
    }
    return map;
}

stages::ViewMaps ProgramMatcher::match(const StereoPair& pair, const stages::DisparityConfig& range,
                                       int threads, RunLog& log) {
    const int least_px = range.min_disparity_px;
    stages::ViewMaps maps{{}, {}, true};
    const auto ask = [&](const StereoPair& views, const std::string& view) {
        if (least_px == 0) return answer(views, view, range, threads, maps.is_dense, log);
        DisparityMap map = answer({views.left, moved_left(views.right, -least_px)}, view, range, threads,
                                  maps.is_dense, log);
        for (float& d : map.values)
            if (DisparityMap::known(d)) d += static_cast<float>(least_px);
        return map;
    };
    maps.left = ask(pair, "left");
    log.progress(0.5);
    maps.right = stages::mirrored(ask(stages::mirrored(pair), "right"));
    return maps;
}

}  // namespace hexrelief::job
