#include <charconv>
#include <cmath>
#include <fstream>
#include <set>
#include <string_view>

#include "exporters/inspect/describe_formats.h"

namespace hexrelief::inspect {
namespace {

namespace fs = std::filesystem;

bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r';
}

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
    return text;
}

// Takes the next word off the line; empty at its end.
std::string_view next_word(std::string_view& line) {
    line = trimmed(line);
    std::size_t end = 0;
    while (end < line.size() && !is_blank(line[end])) ++end;
    const std::string_view word = line.substr(0, end);
    line.remove_prefix(end);
    return word;
}

bool to_float(std::string_view word, float& value) {
    if (!word.empty() && word.front() == '+') word.remove_prefix(1);
    const auto result = std::from_chars(word.data(), word.data() + word.size(), value);
    return result.ec == std::errc() && result.ptr == word.data() + word.size() && std::isfinite(value);
}

class ObjReader {
  public:
    explicit ObjReader(const fs::path& path) : path_(path) {}

    void line(std::string_view text) {
        ++line_;
        text = trimmed(text);
        if (!text.empty() && text.front() == '#') {
            text.remove_prefix(1);
            if (out.generator.empty()) out.generator = trimmed(text);
            return;
        }
        const std::string_view word = next_word(text);
        if (word == "v")
            vertex(text);
        else if (word == "vn")
            out.normals = true;
        else if (word == "vt")
            out.texcoords = true;
        else if (word == "f")
            face(text);
        else if (word == "mtllib")
            library(fs::path(std::string(trimmed(text))));
        else if (word.find('\0') != std::string_view::npos)
            fail("it is no text");
    }

    MeshDescription out;

  private:
    [[noreturn]] void fail(const std::string& what) const {
        fail_reading(path_, "line " + std::to_string(line_) + ": " + what);
    }

    void vertex(std::string_view text) {
        float values[7] = {};
        int count = 0;
        for (std::string_view word = next_word(text); !word.empty(); word = next_word(text))
            if (count == 7 || !to_float(word, values[count++])) fail("a vertex that is not 3 to 7 numbers");
        if (count < 3) fail("a vertex of fewer than 3 numbers");
        ++out.vertices;
        out.colors |= count >= 6;
        include_point(out, {values[0], values[1], values[2]});
    }

    void face(std::string_view text) {
        long long corners = 0;
        for (std::string_view word = next_word(text); !word.empty(); word = next_word(text), ++corners) {
            long long index = 0;
            const auto result = std::from_chars(word.data(), word.data() + word.size(), index);
            if (result.ec != std::errc() || index == 0 || index > out.vertices || index < -out.vertices)
                fail("a face that uses vertex '" + std::string(word.substr(0, word.find('/'))) + "' of " +
                     std::to_string(out.vertices));
        }
        if (corners < 3) fail("a face of fewer than 3 corners");
        out.triangles += corners - 2;
    }

    // Adds the size of each texture that the material library names. Each library is read once.
    void library(const fs::path& name) {
        const fs::path path = path_.parent_path() / name;
        std::error_code ignored;  // a pipe or a device might never end
        if (!fs::is_regular_file(path, ignored) || !libraries_.insert(path).second) return;
        std::ifstream stream(path);
        for (std::string text; std::getline(stream, text);) {
            std::string_view rest = text;
            if (next_word(rest) != "map_Kd") continue;
            std::error_code code;
            const auto size = fs::file_size(path_.parent_path() / std::string(trimmed(rest)), code);
            if (!code) out.texture_bytes += static_cast<long long>(size);
        }
    }

    const fs::path& path_;
    std::set<fs::path> libraries_;
    long long line_ = 0;
};

}  // namespace

MeshDescription describe_obj(const fs::path& path) {
    const std::vector<std::uint8_t> bytes = read_file(path);
    ObjReader reader(path);
    std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    while (!text.empty()) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        reader.line(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    if (reader.out.vertices == 0) fail_reading(path, "it holds no OBJ vertex");
    return reader.out;
}

}  // namespace hexrelief::inspect
