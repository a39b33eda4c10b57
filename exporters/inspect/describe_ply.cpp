#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <limits>
#include <set>
#include <string_view>

#include "exporters/inspect/describe_formats.h"

namespace hexrelief::inspect {
namespace {

namespace fs = std::filesystem;

enum class Encoding { ascii, little_endian, big_endian };
template <typename T>
double number_in(const char* bytes) {
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return static_cast<double>(value);
}

struct NumberType {
    std::string_view name, other_name;
    std::size_t bytes;
    double (*read)(const char* bytes);
};
template <typename T>
constexpr NumberType type_of(std::string_view name, std::string_view other_name) {
    return {name, other_name, sizeof(T), number_in<T>};
}
constexpr NumberType kNumberTypes[] = {
    type_of<std::int8_t>("char", "int8"),    type_of<std::uint8_t>("uchar", "uint8"),
    type_of<std::int16_t>("short", "int16"), type_of<std::uint16_t>("ushort", "uint16"),
    type_of<std::int32_t>("int", "int32"),   type_of<std::uint32_t>("uint", "uint32"),
    type_of<float>("float", "float32"),      type_of<double>("double", "float64")};

const NumberType* find_type(std::string_view name) {
    const auto found = std::ranges::find_if(
        kNumberTypes, [&](const NumberType& type) { return name == type.name || name == type.other_name; });
    return found == std::end(kNumberTypes) ? nullptr : found;
}

struct Property {
    std::string name;
    const NumberType* type = nullptr;
    const NumberType* count_type = nullptr;  // of a list; null = it is none
};

struct Element {
    std::string name;
    long long count = 0;
    std::vector<Property> properties;
};

std::vector<std::string_view> words_of(std::string_view line) {
    std::vector<std::string_view> words;
    while (true) {
        const std::size_t begin = line.find_first_not_of(" \t\r");
        if (begin == std::string_view::npos) return words;
        const std::size_t end = std::min(line.find_first_of(" \t\r", begin), line.size());
        words.push_back(line.substr(begin, end - begin));
        line.remove_prefix(end);
    }
}

class PlyReader {
  public:
    PlyReader(const fs::path& path, const std::vector<std::uint8_t>& bytes)
        : path_(path), rest_(reinterpret_cast<const char*>(bytes.data()), bytes.size()) {}

    MeshDescription read() {
        read_header();
        for (const Element& element : elements_) {
            // Each item takes at least one byte, so a huge count cannot keep the reader busy, not even if the
            // element has no property.
            if (element.count > static_cast<long long>(rest_.size())) fail("it is truncated");
            if (element.name == "vertex") out_.vertices += element.count;
            for (long long i = 0; i < element.count; ++i) read_item(element);
        }
        if (out_.vertices == 0) fail("it holds no vertex");
        return out_;
    }

  private:
    [[noreturn]] void fail(const std::string& what) const { fail_reading(path_, what); }

    std::string_view next_line() {
        const std::size_t end = rest_.find('\n');
        if (end == std::string_view::npos) fail("its PLY header does not end");
        const std::string_view line = rest_.substr(0, end);
        rest_.remove_prefix(end + 1);
        return line;
    }

    void read_header() {
        if (!rest_.starts_with("ply\n") && !rest_.starts_with("ply\r\n")) fail("it is not a PLY file");
        next_line();
        bool has_format = false;
        while (true) {
            const std::string_view line = next_line();
            const std::vector<std::string_view> words = words_of(line);
            if (words.empty() || words[0] == "obj_info") continue;
            if (words[0] == "end_header") break;
            if (words[0] == "comment") {
                if (out_.generator.empty() && words.size() > 1)
                    out_.generator = std::string(words[1].data(), words.back().data() + words.back().size());
            } else if (words[0] == "format" && words.size() == 3) {
                has_format = words[1] == "ascii" || words[1].starts_with("binary_");
                encoding_ = words[1] == "ascii"                  ? Encoding::ascii
                            : words[1] == "binary_little_endian" ? Encoding::little_endian
                                                                 : Encoding::big_endian;
            } else if (words[0] == "element" && words.size() == 3) {
                Element element{std::string(words[1]), 0, {}};
                const auto result =
                    std::from_chars(words[2].data(), words[2].data() + words[2].size(), element.count);
                if (result.ec != std::errc() || element.count < 0) fail_header(line);
                elements_.push_back(element);
            } else if (words[0] == "property") {
                add_property(line, words);
            } else {
                fail_header(line);
            }
        }
        if (!has_format) fail("its PLY header names no format");
    }

    [[noreturn]] void fail_header(std::string_view line) const {
        fail("its PLY header has the malformed line '" + std::string(line.substr(0, 80)) + "'");
    }

    void add_property(std::string_view line, const std::vector<std::string_view>& words) {
        Property property;
        const bool is_list = words.size() == 5 && words[1] == "list";
        if (is_list) property.count_type = find_type(words[2]);
        if (is_list || words.size() == 3) property.type = find_type(words[words.size() - 2]);
        const bool sound = !elements_.empty() && property.type && (!is_list || property.count_type);
        if (!sound) fail_header(line);
        property.name = std::string(words.back());
        if (elements_.back().name == "vertex") {
            const std::string& name = property.name;
            out_.normals |= name == "nx";
            out_.texcoords |= name == "u" || name == "s" || name == "texture_u";
            out_.colors |= name == "red" || name == "diffuse_red";
        }
        elements_.back().properties.push_back(property);
    }

    double next_number(const NumberType& type) {
        if (encoding_ == Encoding::ascii) {
            const std::size_t begin = rest_.find_first_not_of(" \t\r\n");
            rest_.remove_prefix(std::min(begin, rest_.size()));
            if (rest_.empty()) fail("it is truncated");
            double value = 0;
            const auto result = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
            if (result.ec != std::errc()) fail("it has something else where a number belongs");
            rest_.remove_prefix(static_cast<std::size_t>(result.ptr - rest_.data()));
            return value;
        }
        char bytes[8];
        if (rest_.size() < type.bytes) fail("it is truncated");
        std::memcpy(bytes, rest_.data(), type.bytes);
        rest_.remove_prefix(type.bytes);
        if (encoding_ == Encoding::big_endian) std::reverse(bytes, bytes + type.bytes);
        return type.read(bytes);
    }

    void read_item(const Element& element) {
        const bool is_vertex = element.name == "vertex", is_face = element.name == "face";
        Vec3f point;
        int coordinates = 0;
        for (const Property& property : element.properties) {
            if (property.count_type) {
                const double count = next_number(*property.count_type);
                if (!(count >= 0) || count > static_cast<double>(rest_.size())) fail("it is truncated");
                const bool indices = is_face && property.name.starts_with("vertex_ind");
                for (auto left = static_cast<long long>(std::ceil(count)); left > 0; --left) {
                    const double index = next_number(*property.type);
                    if (indices && !(index >= 0 && index < static_cast<double>(out_.vertices)))
                        fail("a face uses a vertex that is not there");
                }
                if (indices) out_.triangles += std::max(0LL, static_cast<long long>(count) - 2);
                continue;
            }
            const double value = next_number(*property.type);
            if (is_vertex && property.name == "provenance" && value >= 0 &&
                value < static_cast<double>(out_.provenance.size()))
                ++out_.provenance[static_cast<std::size_t>(value)];
            if (!is_vertex || property.name.size() != 1) continue;
            float* const targets[] = {&point.x, &point.y, &point.z};
            const int axis = property.name[0] - 'x';
            if (axis < 0 || axis > 2) continue;
            if (!(std::abs(value) <= std::numeric_limits<float>::max()))
                fail("a vertex is not a finite number");
            *targets[axis] = static_cast<float>(value);
            ++coordinates;
        }
        if (coordinates == 3) include_point(out_, point);
    }

    const fs::path& path_;
    std::string_view rest_;
    Encoding encoding_ = Encoding::ascii;
    std::vector<Element> elements_;
    MeshDescription out_;
};

}  // namespace

MeshDescription describe_ply(const fs::path& path) {
    const std::vector<std::uint8_t> bytes = read_file(path);
    return PlyReader(path, bytes).read();
}

MeshDescription describe_stl(const std::filesystem::path& path) {
    const std::vector<std::uint8_t> bytes = read_file(path);
    constexpr std::size_t kHeader = 80, kStart = kHeader + 4, kTriangle = 50;
    if (bytes.size() < kStart) fail_reading(path, "it is too short for a binary STL");
    std::uint32_t triangles;
    std::memcpy(&triangles, bytes.data() + kHeader, 4);
    if (bytes.size() != kStart + kTriangle * triangles) {
        const bool is_text = std::memcmp(bytes.data(), "solid", 5) == 0;
        fail_reading(path, is_text ? "it is an STL as text, which is not read"
                                   : "it has " + std::to_string(bytes.size()) +
                                         " bytes, which are not those of " + std::to_string(triangles) +
                                         " triangles");
    }
    MeshDescription out;
    out.triangles = triangles;
    std::set<std::array<float, 3>> corners;
    for (std::size_t i = 0; i < 3 * std::size_t{triangles}; ++i) {
        std::array<float, 3> p;
        std::memcpy(p.data(), bytes.data() + kStart + kTriangle * (i / 3) + 12 * (1 + i % 3), 12);
        if (!(p[0] - p[0] == 0 && p[1] - p[1] == 0 && p[2] - p[2] == 0))
            fail_reading(path, "a corner of triangle " + std::to_string(i / 3) + " is no number");
        corners.insert(p);
        include_point(out, {p[0], p[1], p[2]});
    }
    out.vertices = static_cast<long long>(corners.size());
    out.geometry_bytes.emplace_back("triangles", static_cast<long long>(kTriangle * triangles));
    const char* text = reinterpret_cast<const char*>(bytes.data());
    out.generator.assign(text, strnlen(text, kHeader));
    constexpr std::string_view kOurs = "binary STL, ";
    if (out.generator.starts_with(kOurs)) {
        out.generator.erase(0, kOurs.size());
        out.generator.resize(std::min(out.generator.size(), out.generator.find(", +")));  // the axes
    }
    for (char& c : out.generator)
        if (c < ' ' || c > '~') c = '?';
    return out;
}

}  // namespace hexrelief::inspect
