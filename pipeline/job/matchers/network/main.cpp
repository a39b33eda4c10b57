// hexrelief-onnx MODEL KIND THREADS: matches pairs by a network, as a worker of disparity.worker does. It is
// a process of its own because a model is a file of anybody's, which may crash the library that runs it or
// never end there.
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "exporters/images/image_writer.h"
#include "pipeline/data/error.h"
#include "pipeline/job/matchers/network/network_matcher.h"
#include "pipeline/readers/image_reader.h"

namespace {

using namespace hexrelief;
using Json = nlohmann::json;

void limit_resources() {
    const rlimit none{0, 0};
    ::setrlimit(RLIMIT_CORE, &none);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // which reserve terabytes
    const rlim_t all =
        static_cast<rlim_t>(::sysconf(_SC_PHYS_PAGES)) * static_cast<rlim_t>(::sysconf(_SC_PAGESIZE));
    rlimit memory{};
    ::getrlimit(RLIMIT_AS, &memory);
    memory.rlim_cur = std::min({memory.rlim_cur, memory.rlim_max, all});
    ::setrlimit(RLIMIT_AS, &memory);
#endif
}

void write_line(int to, const std::string& line) {
    for (std::size_t written = 0; written < line.size();) {
        const ssize_t bytes = ::write(to, line.data() + written, line.size() - written);
        if (bytes < 0 && errno != EINTR) return;
        if (bytes > 0) written += static_cast<std::size_t>(bytes);
    }
}

Json answer_to(const Json& request, job::NetworkMatcher& matcher) {
    const auto path = [&](const char* key) {
        return std::filesystem::path(request.at(key).get<std::string>());
    };
    const job::NetworkAnswer answer =
        matcher.match({readers::read_image(path("left")), readers::read_image(path("right"))},
                      request.at("ndisp").get<int>());
    const int width = answer.map.width, height = answer.map.height;
    exporters::write_pfm(path("out"), width, height, answer.map.values);
    if (!answer.confidence.empty())
        exporters::write_pfm(path("confidence"), width, height, answer.confidence);
    return {{"ok", true}, {"told", answer.told}};
}

}  // namespace

int main(int count, char** words) {
    // Libraries that print to the standard output would spoil the answers.
    const int answers = ::dup(STDOUT_FILENO);
    ::dup2(STDERR_FILENO, STDOUT_FILENO);
    if (count != 4) return static_cast<int>(ErrorKind::usage);
    limit_resources();
    std::optional<job::NetworkMatcher> matcher;
    for (std::string line; std::getline(std::cin, line);) {
        Json answer;
        try {
            if (!matcher) matcher.emplace(words[1], words[2], std::stoi(words[3]));
            answer = answer_to(Json::parse(line), *matcher);
        } catch (const Error& error) {
            answer = {{"error", error.what()}, {"usage", error.kind() == ErrorKind::usage}};
        } catch (const std::bad_alloc&) {
            answer = {{"error", std::string(words[1]) +
                                    ": the network needs more memory than there is; lower "
                                    "disparity.working_px"}};
        } catch (const std::exception& error) {
            answer = {{"error", std::string(words[1]) + ": " + error.what()}};
        }
        write_line(answers, answer.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
    }
}
