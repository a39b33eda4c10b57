// Reads .npz, a ZIP archive of numpy's arrays.
#include <algorithm>
#include <optional>
#include <string_view>

#include "pipeline/data/error.h"
#include "pipeline/readers/codecs.h"
#include "pipeline/readers/depth/map_names.h"
#include "pipeline/readers/depth/npy_shape.h"
#include "pipeline/readers/depth/zip_archive.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

constexpr std::string_view kEnding = ".npy";
constexpr std::size_t kStartBytes = 4096;  // hold the header of any array without fields

std::string array_name(const ZipMember& member) {
    return member.name.substr(0, member.name.size() - kEnding.size());
}

std::vector<ZipMember> arrays_of(const SourceFile& source) {
    std::vector<ZipMember> arrays = list_members(source);
    std::erase_if(arrays, [](const ZipMember& member) { return !member.name.ends_with(kEnding); });
    if (arrays.empty())
        refuse(source.path,
               "it is a ZIP archive without numpy arrays (.npy), as PyTorch's are; save the array by "
               "numpy.save");
    return arrays;
}

std::vector<std::string> names_of(const std::vector<ZipMember>& arrays) {
    std::vector<std::string> names(arrays.size());
    std::ranges::transform(arrays, names.begin(), array_name);
    return names;
}

// Returns nothing for arrays that are not of numbers.
std::optional<NpyShape> shape_of(const SourceFile& source, const ZipMember& array) {
    try {
        return read_npy_shape({source.path, unpack_start(source, array, kStartBytes)});
    } catch (const Error&) {
        return std::nullopt;
    }
}

// True for two sides larger than a matrix has.
bool is_map(const SourceFile& source, const ZipMember& array) {
    const std::optional<NpyShape> found = shape_of(source, array);
    return found && std::ranges::count_if(found->shape, [](auto side) { return side > 4; }) == 2;
}

// Returns the index of the array that the key names, with or without a number in brackets, of the only one,
// of the one with the most usual name, or of the only one that can be a map.
std::size_t index_of_array(const SourceFile& source, const std::vector<ZipMember>& arrays) {
    const std::vector<std::string> names = names_of(arrays);
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    text = printable(text, 400);
    const std::string wanted =
        source.key.substr(0, source.key.ends_with(']') ? source.key.rfind('[') : source.key.size());
    if (!wanted.empty()) {
        auto found = std::ranges::find(names, source.key);
        if (found == names.end()) found = std::ranges::find(names, wanted);
        if (found == names.end())
            refuse(source.path, "it has no array " + excerpt(wanted) + "; it has " + text);
        return static_cast<std::size_t>(found - names.begin());
    }
    if (arrays.size() == 1) return 0;
    if (const auto usual = usual_name(names, source.wanted)) return *usual;
    const auto can_be = [&](const ZipMember& array) { return is_map(source, array); };
    const auto first = std::ranges::find_if(arrays, can_be);
    if (first == arrays.end() || std::find_if(first + 1, arrays.end(), can_be) != arrays.end())
        refuse(source.path, "it has several arrays; " + std::string(source.several) + ": " + text);
    return static_cast<std::size_t>(first - arrays.begin());
}

SourceFile chosen_array(const SourceFile& source) {
    const std::vector<ZipMember> arrays = arrays_of(source);
    const ZipMember& chosen = arrays[index_of_array(source, arrays)];
    const std::uint64_t most_bytes =
        static_cast<std::uint64_t>(source.limits.max_pixels) * 8 + kLongestNpyHeader + 64;
    SourceFile array{source.path.string() + ":" + printable(array_name(chosen), 40),
                     unpack(source, chosen, most_bytes)};
    if (source.key != array_name(chosen)) array.key = source.key;
    if (array.key.empty()) array.key = array_name(chosen);  // for the advice to add a number
    array.limits = source.limits;
    return array;
}

}  // namespace

FileDescription describe_npz(const SourceFile& source) {
    FileDescription found = describe_npy(chosen_array(source));
    found.format = "npz";
    return found;
}

std::vector<std::string> list_npz(const SourceFile& source) {
    std::vector<std::string> lines;
    for (const ZipMember& array : arrays_of(source)) {
        std::string line = array_name(array) + ":";
        if (const std::optional<NpyShape> found = shape_of(source, array)) {
            const char* separator = " ";
            for (const unsigned long long side : found->shape) {
                line += separator + std::to_string(side);
                separator = " x ";
            }
            line += " " + found->type;
        } else {
            line += " no numbers";
        }
        lines.push_back(line);
    }
    return lines;
}

Raster decode_npz(const SourceFile& source) {
    return decode_npy(chosen_array(source));
}

}  // namespace hexrelief::readers::codec
