// Reads numpy's arrays: .npy.
#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstring>
#include <initializer_list>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>

#include "pipeline/data/number_text.h"
#include "pipeline/readers/codecs.h"
#include "pipeline/readers/depth/npy_shape.h"
#include "pipeline/readers/parse_text.h"

namespace hexrelief::readers::codec {
namespace {

constexpr std::size_t kMagicBytes = 8;

struct NpyHeader {
    char kind = 0;  // 'u', 'i', 'f' or 'b'
    unsigned item_bytes = 0;
    bool big_endian = false;
    bool column_major = false;
    std::vector<unsigned long long> shape;
    unsigned long long width = 0, height = 0;  // of a map
    unsigned long long maps = 1, map = 0;      // number of maps, and the one that is read
    bool are_interleaved = false;              // the maps are the last dimension of the shape, not the first
    std::size_t samples_at = 0;
};

[[noreturn]] void refuse_header(const SourceFile& source) {
    refuse(source.path, "malformed NPY header; save the array again with numpy.save");
}

// Parses the header's text, a Python dictionary, from left to right.
class DictionaryText {
  public:
    DictionaryText(const SourceFile& source, std::string_view text) : source_(source), text_(text) {}

    bool skip(char wanted) {
        skip_space();
        if (text_.empty() || text_.front() != wanted) return false;
        text_.remove_prefix(1);
        return true;
    }
    void expect(char wanted) {
        if (!skip(wanted)) refuse_header(source_);
    }
    std::string_view quoted() {
        const char mark = skip('\'') ? '\'' : '"';
        if (mark == '"') expect('"');
        const std::size_t end = text_.find(mark);
        if (end == std::string_view::npos) refuse_header(source_);
        return take(end, 1);
    }
    std::string_view word() {
        skip_space();
        std::size_t end = 0;
        while (end < text_.size() && (std::isalnum(static_cast<unsigned char>(text_[end])) != 0)) ++end;
        return take(end, 0);
    }
    bool starts_with(char c) {
        skip_space();
        return !text_.empty() && text_.front() == c;
    }
    bool at_end() {
        skip_space();
        return text_.empty();
    }

  private:
    void skip_space() { text_.remove_prefix(std::min(text_.find_first_not_of(" \n"), text_.size())); }
    std::string_view take(std::size_t count, std::size_t more) {
        const std::string_view taken = text_.substr(0, count);
        text_.remove_prefix(count + more);
        return taken;
    }

    const SourceFile& source_;
    std::string_view text_;
};

void take_type(const SourceFile& source, std::string_view type, NpyHeader& header) {
    constexpr std::string_view orders = "<>|=";
    if (type == "|O") refuse(source.path, "it holds Python's objects; save the array alone by numpy.save");
    if (type.size() < 3 || orders.find(type[0]) == std::string_view::npos) refuse_header(source);
    header.big_endian = type[0] == '>';
    header.kind = type[1];
    const auto bytes = parse_number(type.substr(2));
    const auto is = [&](char kind, std::initializer_list<int> sizes) {
        return header.kind == kind && bytes && std::ranges::find(sizes, *bytes) != sizes.end();
    };
    if (!is('b', {1}) && !is('u', {1, 2, 4, 8}) && !is('i', {1, 2, 4, 8}) && !is('f', {2, 4, 8}))
        refuse(source.path,
               "its numbers are of type " + excerpt(type) + "; save it as float32 or uint16 (array.astype)");
    header.item_bytes = static_cast<unsigned>(*bytes);
}

std::string shape_text(const std::vector<unsigned long long>& shape) {
    return "(" + joined(shape, ", ", [](unsigned long long side) { return std::to_string(side); }) + ")";
}

// Returns the number in brackets at the key's end: 2 for "depth[2]".
std::optional<double> index_of(const std::string& key) {
    const std::size_t open = key.rfind('[');
    if (open == std::string::npos || !key.ends_with(']')) return std::nullopt;
    return parse_number(std::string_view(key).substr(open + 1, key.size() - open - 2));
}

// Takes one of several maps, (N, H, W), or the channels of pixels, (H, W, N).
void take_map(const SourceFile& source, std::vector<unsigned long long>& sides, NpyHeader& header) {
    constexpr unsigned long long most_channels = 4;
    header.are_interleaved = sides[2] <= most_channels && sides[0] > most_channels;
    header.maps = header.are_interleaved ? sides[2] : sides[0];
    const std::optional<double> index = index_of(source.key);
    if (!index || !(*index >= 0) || *index >= static_cast<double>(header.maps) || header.column_major)
        refuse(source.path,
               "its shape is " + shape_text(header.shape) + "; a map has two dimensions, height and width: " +
                   (header.column_major ? "save one of them alone"
                                        : "name one of its " + std::to_string(header.maps) +
                                              " by a number in brackets, --key " +
                                              source.key.substr(0, source.key.find('[')) + "[0]"));
    header.map = static_cast<unsigned long long>(*index);
    sides.erase(header.are_interleaved ? sides.end() - 1 : sides.begin());
}

// Takes the two sides of the shape; further sides of 1, such as networks' batches and channels, are ignored.
void take_shape(const SourceFile& source, NpyHeader& header) {
    std::vector<unsigned long long> sides = header.shape;
    for (auto side = sides.begin(); sides.size() > 2 && side != sides.end();)
        side = *side == 1 ? sides.erase(side) : side + 1;
    if (sides.size() == 3) take_map(source, sides, header);
    if (sides.size() != 2)
        refuse(source.path,
               "its shape is " + shape_text(header.shape) + "; a map has two dimensions, height and width");
    header.height = sides[0];
    header.width = sides[1];
    check_size(source, header.width, header.height);
}

std::vector<unsigned long long> read_shape(const SourceFile& source, DictionaryText& text) {
    std::vector<unsigned long long> shape;
    text.expect('(');
    while (!text.skip(')')) {
        const auto side = parse_number(text.word());
        if (!side || *side < 0 || *side > 1e15 || shape.size() == 32) refuse_header(source);
        shape.push_back(static_cast<unsigned long long>(*side));
        if (!text.skip(',') && !text.starts_with(')')) refuse_header(source);
    }
    return shape;
}

void read_dictionary(const SourceFile& source, std::string_view header_text, NpyHeader& header) {
    DictionaryText text(source, header_text);
    std::optional<std::vector<unsigned long long>> shape;
    bool has_type = false, has_order = false;
    text.expect('{');
    while (!text.skip('}')) {
        const std::string_view key = text.quoted();
        text.expect(':');
        if (key == "descr" && !has_type) {
            if (text.starts_with('['))
                refuse(source.path, "it is a structured array; save one of its fields alone");
            take_type(source, text.quoted(), header);
            has_type = true;
        } else if (key == "fortran_order" && !has_order) {
            const std::string_view word = text.word();
            if (word != "True" && word != "False") refuse_header(source);
            header.column_major = word == "True";
            has_order = true;
        } else if (key == "shape" && !shape) {
            shape = read_shape(source, text);
        } else {
            refuse_header(source);
        }
        if (!text.skip(',') && !text.starts_with('}')) refuse_header(source);
    }
    if (!has_type || !has_order || !shape || !text.at_end()) refuse_header(source);
    header.shape = std::move(*shape);
}

NpyHeader read_any_header(const SourceFile& source) {
    const auto& bytes = source.bytes;
    NpyHeader header;
    const std::size_t length_bytes = bytes.size() > kMagicBytes && bytes[6] == 1 ? 2 : 4;
    if (bytes.size() < kMagicBytes + length_bytes) refuse_header(source);
    if (bytes[6] < 1 || bytes[6] > 3)
        refuse(source.path, "NPY version " + std::to_string(bytes[6]) + " is not known, only 1 to 3");
    std::size_t length = 0;
    for (std::size_t i = length_bytes; i-- > 0;) length = length << 8 | bytes[kMagicBytes + i];
    header.samples_at = kMagicBytes + length_bytes + length;
    if (length > kLongestNpyHeader || header.samples_at > bytes.size()) refuse_header(source);
    read_dictionary(
        source, {reinterpret_cast<const char*>(bytes.data()) + kMagicBytes + length_bytes, length}, header);
    return header;
}

NpyHeader read_npy_header(const SourceFile& source) {
    NpyHeader header = read_any_header(source);
    take_shape(source, header);
    return header;
}

void check_samples(const SourceFile& source, const NpyHeader& header) {
    const unsigned long long of_map = header.width * header.height * header.item_bytes,
                             found = source.size() - header.samples_at;
    const bool is_truncated = header.maps > found / of_map;  // the product of all might wrap
    if (is_truncated || found != header.maps * of_map)
        refuse(source.path, (is_truncated ? "truncated: " : "malformed: ") +
                                std::string("the header promises ") +
                                (header.maps == 1 ? "" : std::to_string(header.maps) + " times ") +
                                std::to_string(of_map) + " bytes of samples, " + std::to_string(found) +
                                " are there; copy or save it again");
}

template <typename Stored>
Stored stored_at(const std::uint8_t* from, bool swap) {
    std::array<std::uint8_t, sizeof(Stored)> bytes;
    std::memcpy(bytes.data(), from, sizeof(Stored));
    if (swap) std::ranges::reverse(bytes);
    return std::bit_cast<Stored>(bytes);
}

// Calls put(index, number) for each sample, in the order of rows.
template <typename Stored, typename Put>
void each_sample(const SourceFile& source, const NpyHeader& header, Put put) {
    const bool swap = header.big_endian == (std::endian::native == std::endian::little);
    const std::uint8_t* const first = source.bytes.data() + header.samples_at;
    for (std::size_t y = 0; y < header.height; ++y)
        for (std::size_t x = 0; x < header.width; ++x) {
            std::size_t stored = header.column_major ? x * header.height + y : y * header.width + x;
            stored = header.are_interleaved ? stored * header.maps + header.map
                                            : stored + header.map * header.width * header.height;
            put(y * header.width + x, stored_at<Stored>(first + stored * sizeof(Stored), swap));
        }
}

struct Half {
    std::uint16_t bits;
    explicit operator float() const { return float_of_half(bits); }
    explicit operator double() const { return float_of_half(bits); }
};

template <typename Stored, typename Sample>
std::vector<Sample> numbers(const SourceFile& source, const NpyHeader& header) {
    std::vector<Sample> samples(header.width * header.height);
    each_sample<Stored>(source, header,
                        [&](std::size_t i, Stored value) { samples[i] = static_cast<Sample>(value); });
    return samples;
}

// Returns the result of use() for a value of the type in which the numbers are stored.
template <typename Use>
auto with_stored_type(const NpyHeader& header, const Use& use) {
    const bool is_float = header.kind == 'f', is_signed = header.kind == 'i';
    switch (header.item_bytes) {
        case 1:
            return is_signed ? use(std::int8_t{}) : use(std::uint8_t{});
        case 2:
            return is_float ? use(Half{}) : is_signed ? use(std::int16_t{}) : use(std::uint16_t{});
        case 4:
            return is_float ? use(float{}) : is_signed ? use(std::int32_t{}) : use(std::uint32_t{});
        default:
            return is_float ? use(double{}) : is_signed ? use(std::int64_t{}) : use(std::uint64_t{});
    }
}

Raster read_samples(const SourceFile& source, const NpyHeader& header) {
    Raster raster{.width = static_cast<int>(header.width),
                  .height = static_cast<int>(header.height),
                  .max_value = header.kind == 'b'       ? 1u
                               : header.item_bytes == 1 ? 255u
                                                        : 65535u};
    with_stored_type(header, [&]<typename Stored>(Stored) {
        if constexpr (std::is_same_v<Stored, std::uint8_t>)
            raster.samples = numbers<Stored, std::uint8_t>(source, header);
        else if constexpr (std::is_integral_v<Stored>)
            hold_integers(raster, numbers<Stored, float>(source, header), 8 * sizeof(Stored),
                          std::is_signed_v<Stored>);
        else
            raster.samples = numbers<Stored, float>(source, header);
    });
    return raster;
}

FileDescription description(const NpyHeader& header) {
    return {"npy", static_cast<int>(header.width),          static_cast<int>(header.height),
            1,     static_cast<int>(8 * header.item_bytes), header.kind == 'f'};
}

}  // namespace

FileDescription describe_npy(const SourceFile& source) {
    const NpyHeader header = read_npy_header(source);
    check_samples(source, header);
    return description(header);
}

Raster decode_npy(const SourceFile& source) {
    const NpyHeader header = read_npy_header(source);
    check_samples(source, header);
    return read_samples(source, header);
}

std::vector<double> read_npy_numbers(const SourceFile& source) {
    NpyHeader header = read_any_header(source);
    std::vector<unsigned long long> sides = header.shape;
    std::erase(sides, 1);
    if (sides.size() > 4 || (header.column_major && sides.size() > 2) ||
        std::ranges::any_of(sides, [](auto side) { return side == 0 || side > 4096; }))
        refuse(source.path, "its shape is not of numbers or of a matrix");
    header.width = sides.empty() ? 1 : sides.back();
    header.height = 1;
    for (std::size_t i = 0; i + 1 < sides.size(); ++i) header.height *= sides[i];
    check_samples(source, header);
    if (header.kind != 'f' && header.kind != 'i')
        refuse(source.path, "its numbers must be floats or signed integers");
    return with_stored_type(header,
                            [&]<typename Stored>(Stored) { return numbers<Stored, double>(source, header); });
}

NpyShape read_npy_shape(const SourceFile& source) {
    const NpyHeader header = read_any_header(source);
    const char* const kind = header.kind == 'f'   ? "float"
                             : header.kind == 'i' ? "int"
                             : header.kind == 'u' ? "uint"
                                                  : "bool";
    return {header.shape, header.kind == 'b' ? kind : kind + std::to_string(8 * header.item_bytes)};
}

}  // namespace hexrelief::readers::codec
