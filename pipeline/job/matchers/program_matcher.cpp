#include "pipeline/job/matchers/program_matcher.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "exporters/images/image_writer.h"
#include "pipeline/config/shell_words.h"
#include "pipeline/data/error.h"
#include "pipeline/files/temporary_folder.h"
#include "pipeline/job/matchers/fit_answer.h"
#include "pipeline/readers/disparity_reader.h"
#include "pipeline/readers/parse_text.h"
#include "pipeline/stages/other_views/other_view.h"

namespace hexrelief::job {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// What a program is told of a pair; the names are those of its placeholders and of its requests.
struct Question {
    fs::path left, right, out;
    int ndisp;
};

// Returns the words with their placeholders filled in. {out.EXT} is a map of another format than PFM.
std::vector<std::string> filled_in(std::vector<std::string> words, Question& question) {
    const std::map<std::string, std::string> values{{"{left}", question.left.string()},
                                                    {"{right}", question.right.string()},
                                                    {"{ndisp}", std::to_string(question.ndisp)}};
    for (std::string& word : words) {
        for (const auto& [name, value] : values)
            for (std::size_t at = 0; (at = word.find(name, at)) != std::string::npos; at += value.size())
                word.replace(at, name.size(), value);
        const std::size_t at = word.find("{out");
        const std::size_t end = at == std::string::npos ? at : word.find('}', at);
        if (end == std::string::npos) continue;
        const std::string extension = word.substr(at + 4, end - at - 4);
        if (!extension.empty()) question.out.replace_extension(extension);
        word.replace(at, end + 1 - at, question.out.string());
    }
    return words;
}

// Checks a worker's answer: {"ok": true}, or {"error": "..."}.
void check_answer(const std::string& line) {
    const Json json = Json::parse(line, nullptr, false);
    const std::string name = "disparity.worker: ";
    if (!json.is_object() || (!json.contains("ok") && !json.contains("error")))
        throw Error(ErrorKind::input,
                    name + "the answer " + readers::codec::excerpt(line) +
                        R"( is not {"ok": true} or {"error": "..."}; what is printed for people )"
                        "belongs to the error stream");
    if (!json.contains("error")) return;
    const Json& error = json.at("error");
    throw Error(ErrorKind::input,
                name + "the pair was not matched: " +
                    readers::codec::excerpt(error.is_string() ? error.get<std::string>() : error.dump()));
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

DisparityMap ProgramMatcher::answer(const StereoPair& pair, const std::string& view,
                                    const stages::DisparityConfig& range, RunLog& log) {
    const files::TemporaryFolder folder;
    Question question{folder.path() / "left.png", folder.path() / "right.png",
                      folder.path() / "disparity.pfm", range.num_disparities_px};
    exporters::write_png(question.left, pair.left);
    exporters::write_png(question.right, pair.right);
    if (!range.command.empty()) {
        ChildProgram(filled_in(config::words_of_line(range.command), question)).finish(range.timeout_s);
    } else {
        const std::vector<std::string> words = config::words_of_line(range.worker);
        if (!worker_ || words != words_) worker_ = std::make_unique<ChildProgram>(words_ = words);
        // Whatever fails, the next pair gets a new worker.
        std::unique_ptr<ChildProgram> asked = std::move(worker_);
        asked->write_line(Json{
            {"left", question.left.string()},
            {"right", question.right.string()},
            {"out", question.out.string()},
            {"ndisp",
             question.ndisp}}.dump(-1, ' ', false, Json::error_handler_t::replace));
        check_answer(asked->read_line(range.timeout_s));
        worker_ = std::move(asked);
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
    return map;
}

stages::ViewMaps ProgramMatcher::match(const StereoPair& pair, const stages::DisparityConfig& range,
                                       RunLog& log) {
    const int least_px = range.min_disparity_px;
    const auto ask = [&](const StereoPair& views, const std::string& view) {
        if (least_px == 0) return answer(views, view, range, log);
        DisparityMap map = answer({views.left, moved_left(views.right, -least_px)}, view, range, log);
        for (float& d : map.values)
            if (DisparityMap::known(d)) d += static_cast<float>(least_px);
        return map;
    };
    DisparityMap left = ask(pair, "left");
    log.progress(0.5);
    return {std::move(left), stages::mirrored(ask(stages::mirrored(pair), "right"))};
}

}  // namespace hexrelief::job
