#include "exporters/images/jpeg_entropy.h"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <functional>

#include "pipeline/data/error.h"

namespace hexrelief::exporters {
namespace {

constexpr int kSide = 8, kCoefficients = kSide * kSide;
constexpr std::size_t kEndOfBlock = 0x00, kSixteenZeros = 0xf0;
constexpr int kMostZeros = 15;
constexpr int kMostDcBits = 11, kMostAcBits = 10;  // of differences, of coefficients

// The places of a block's coefficients from low to high frequencies, and the reverse.
struct Zigzag {
    std::array<std::uint8_t, kCoefficients> place = {}, rank = {};

    constexpr Zigzag() {
        std::uint8_t i = 0;
        for (int sum = 0; sum < 2 * kSide - 1; ++sum)
            for (int k = std::max(0, sum - kSide + 1); k <= std::min(sum, kSide - 1); ++k, ++i) {
                const int row = sum % 2 == 0 ? sum - k : k;
                place[i] = static_cast<std::uint8_t>(row * kSide + sum - row);
                rank[place[i]] = i;
            }
    }
};
constexpr Zigzag kZigzag;

// Returns the rank of the last coefficient that is not 0; 0 if there is none but the first.
int last_rank(const std::int16_t* block) {
    int last = 0;
    for (int row = 0; row < kCoefficients; row += kSide) {
        std::uint64_t halves[2];
        std::memcpy(halves, block + row, sizeof halves);
        if ((halves[0] | halves[1]) == 0) continue;
        for (int i = row; i < row + kSide; ++i)
            if (block[i] != 0) last = std::max<int>(last, kZigzag.rank[i]);
    }
    return last;
}

struct Magnitude {
    std::size_t bits;
    std::uint32_t extra;
};
// Negative values are written as their complement. Blocks of a damaged file may hold values that no file may.
Magnitude magnitude_of(int value, int most_bits) {
    const int bits = std::bit_width(static_cast<unsigned>(std::abs(value)));
    if (bits > most_bits) throw Error(ErrorKind::output, "a JPEG file cannot hold its coefficients");
    return {static_cast<std::size_t>(bits),
            static_cast<std::uint32_t>(value < 0 ? value - 1 : value) & ((1u << bits) - 1)};
}

std::size_t dc_table(std::size_t component) {
    return component == 0 ? 0 : 2;
}

// The code words by JpegSymbols::code_of().
struct Words {
    std::array<std::uint16_t, JpegSymbols::kCodes> word = {};
    std::array<std::uint8_t, JpegSymbols::kCodes> length = {};

    explicit Words(const JpegCodes& codes) {
        for (std::size_t table = 0; table < codes.size(); ++table) {
            unsigned next = 0;
            std::size_t i = 0;
            for (std::size_t bits = 1; bits < codes[table].lengths.size(); ++bits, next *= 2)
                for (int k = 0; k < codes[table].lengths[bits]; ++k, ++i) {
                    const std::size_t code = table * kJpegSymbols + codes[table].symbols[i];
                    word[code] = static_cast<std::uint16_t>(next++);
                    length[code] = static_cast<std::uint8_t>(bits);
                }
        }
    }
    std::uint64_t bits_of(const JpegSymbols& part) const {
        std::uint64_t bits = 0;
        for (std::size_t code = 0; code < JpegSymbols::kCodes; ++code)
            bits += std::uint64_t{part.counts()[code]} * (length[code] + JpegSymbols::extra_bits_of(code));
        return bits;
    }
};

// Collects bits into the bytes of a scan, where a 0 follows each byte of ones.
class BitWriter {
  public:
    BitWriter(const Words& words, std::size_t bytes) : words_(words) { bytes_.reserve(bytes); }

    void put(std::uint64_t bits, int count) {
        bits_ = bits_ << count | bits;
        waiting_ += count;
    }
    void put(std::uint32_t item) {
        const std::size_t code = JpegSymbols::code_of(item);
        const int extra = JpegSymbols::extra_bits_of(code);
        put(std::uint64_t{words_.word[code]} << extra | JpegSymbols::extra_of(item),
            words_.length[code] + extra);
    }
    int waiting() const { return waiting_; }
    // Moves the first byte of those that wait.
    void take_byte() {
        const auto byte = static_cast<std::uint8_t>(bits_ >> (waiting_ -= 8));
        bytes_.push_back(byte);
        if (byte == 0xff) bytes_.push_back(0);
    }
    std::vector<std::uint8_t> bytes() && { return std::move(bytes_); }

  private:
    const Words& words_;
    std::vector<std::uint8_t> bytes_;
    std::uint64_t bits_ = 0;
    int waiting_ = 0;
};

// Returns the bytes of a scan whose first bits are those of one part, which begins at bit `begin`.
std::vector<std::uint8_t> bytes_of(const std::vector<JpegSymbols>& parts, std::size_t part,
                                   const Words& words, std::uint64_t begin) {
    const std::uint64_t bits = words.bits_of(parts[part]);
    const int before = static_cast<int>(begin % 8);  // in a byte that begins with the part before
    if (before > 0 && before + bits <= 8) return {};
    BitWriter writer(words, bits / 8 + bits / 512 + 8);
    writer.put(std::uint64_t{0}, before);
    for (const std::uint32_t item : parts[part].items()) {
        writer.put(item);
        while (writer.waiting() >= 8) writer.take_byte();
    }
    if (writer.waiting() > 0) {
        for (std::size_t next = part + 1; next < parts.size(); ++next)
            for (auto item = parts[next].items().begin();
                 item != parts[next].items().end() && writer.waiting() < 8; ++item)
                writer.put(*item);
        if (writer.waiting() < 8) writer.put(std::uint64_t{0xff} >> writer.waiting(), 8 - writer.waiting());
        writer.take_byte();
    }
    std::vector<std::uint8_t> bytes = std::move(writer).bytes();
    if (before > 0) bytes.erase(bytes.begin());
    return bytes;
}

}  // namespace

JpegSymbols::JpegSymbols(std::size_t blocks) {
    constexpr std::size_t kPerBlock = 8;
    items_.reserve(kPerBlock * blocks);
}

void JpegSymbols::append(std::size_t table, std::size_t symbol, std::uint32_t extra) {
    const std::size_t code = table * kJpegSymbols + symbol;
    ++counts_[code];
    items_.push_back(static_cast<std::uint32_t>(code << 16) | extra);
}

void JpegSymbols::add(std::size_t component, const std::int16_t* block) {
    Component& own = components_[component];
    const std::size_t table = dc_table(component);
    if (own.has_blocks) {
        const Magnitude dc = magnitude_of(block[0] - own.last_dc, kMostDcBits);
        append(table, dc.bits, dc.extra);
    } else {
        own = {true, items_.size(), block[0], 0};
        items_.push_back(0);
    }
    own.last_dc = block[0];
    const int last = last_rank(block);
    int zeros = 0;
    for (int rank = 1; rank <= last; ++rank) {
        const int value = block[kZigzag.place[rank]];
        if (value == 0) {
            ++zeros;
            continue;
        }
        for (; zeros > kMostZeros; zeros -= kMostZeros + 1) append(table + 1, kSixteenZeros, 0);
        const Magnitude ac = magnitude_of(value, kMostAcBits);
        append(table + 1, static_cast<std::size_t>(zeros) << 4 | ac.bits, ac.extra);
        zeros = 0;
    }
    if (last < kCoefficients - 1) append(table + 1, kEndOfBlock, 0);
}

void JpegSymbols::add_border(std::size_t component) {
    const std::size_t table = dc_table(component);
    append(table, 0, 0);
    append(table + 1, kEndOfBlock, 0);
}

void JpegSymbols::follow(const JpegSymbols* before) {
    for (std::size_t component = 0; component < components_.size(); ++component) {
        const Component& own = components_[component];
        if (!own.has_blocks) continue;
        const Magnitude dc =
            magnitude_of(own.first_dc - (before ? before->components_[component].last_dc : 0), kMostDcBits);
        const std::size_t code = dc_table(component) * kJpegSymbols + dc.bits;
        ++counts_[code];
        items_[own.first_item] = static_cast<std::uint32_t>(code << 16) | dc.extra;
    }
}

JpegCode optimal_jpeg_code(const std::uint64_t* counts) {
    // One more symbol than there are takes the code of ones alone, which a file must not have.
    std::array<std::uint64_t, kJpegSymbols + 1> weights;
    std::copy_n(counts, kJpegSymbols, weights.begin());
    weights[kJpegSymbols] = 1;
    std::array<std::vector<std::size_t>, kJpegSymbols + 1>
        members;  // of the trees; a tree is its first member
    for (std::size_t i = 0; i < members.size(); ++i) members[i] = {i};
    std::array<std::size_t, kJpegSymbols + 1> depths = {};
    const auto lightest = [&](std::size_t other) {  // the last of equals
        std::size_t found = weights.size();
        for (std::size_t i = 0; i < weights.size(); ++i)
            if (i != other && weights[i] > 0 && (found == weights.size() || weights[i] <= weights[found]))
                found = i;
        return found;
    };
    for (;;) {
        const std::size_t first = lightest(weights.size()), second = lightest(first);
        if (second == weights.size()) break;
        weights[first] += weights[second];
        weights[second] = 0;
        members[first].insert(members[first].end(), members[second].begin(), members[second].end());
        for (const std::size_t i : members[first]) ++depths[i];
    }
    std::array<int, kJpegSymbols + 1> codes = {};  // of each length
    for (const std::size_t depth : depths) ++codes[depth];
    codes[0] = 0;
    JpegCode code;
    // Two codes that are too long become one that is a bit shorter, and one that lies below a shorter code.
    for (std::size_t bits = codes.size() - 1; bits >= code.lengths.size(); --bits)
        while (codes[bits] > 0) {
            std::size_t shorter = bits - 2;
            while (codes[shorter] == 0) --shorter;
            codes[bits] -= 2;
            ++codes[bits - 1];
            codes[shorter + 1] += 2;
            --codes[shorter];
        }
    std::size_t longest = code.lengths.size() - 1;
    while (longest > 0 && codes[longest] == 0) --longest;
    --codes[longest];  // the additional symbol's
    for (std::size_t bits = 1; bits < code.lengths.size(); ++bits)
        code.lengths[bits] = static_cast<std::uint8_t>(codes[bits]);
    for (std::size_t i = 0; i < kJpegSymbols; ++i)
        if (depths[i] > 0) code.symbols.push_back(static_cast<std::uint8_t>(i));
    std::ranges::stable_sort(code.symbols, {}, [&](std::uint8_t symbol) { return depths[symbol]; });
    return code;
}

JpegCodes optimal_jpeg_codes(const std::vector<JpegSymbols>& parts) {
    std::array<std::uint64_t, JpegSymbols::kCodes> counts = {};
    for (const JpegSymbols& part : parts)
        std::ranges::transform(counts, part.counts(), counts.begin(), std::plus<std::uint64_t>());
    JpegCodes codes;
    for (std::size_t table = 0; table < codes.size(); ++table)
        codes[table] = optimal_jpeg_code(counts.data() + table * kJpegSymbols);
    return codes;
}

void append_jpeg_scan(std::vector<std::uint8_t>& file, const std::vector<JpegSymbols>& parts,
                      const JpegCodes& codes, ThreadPool& pool) {
    const Words words(codes);
    std::vector<std::uint64_t> begins = {0};
    for (const JpegSymbols& part : parts) begins.push_back(begins.back() + words.bits_of(part));
    std::vector<std::vector<std::uint8_t>> bytes(parts.size());
    pool.parallel_for_chunks<1>(parts.size(),
                                [&](std::size_t i) { bytes[i] = bytes_of(parts, i, words, begins[i]); });
    std::size_t size = file.size();
    for (const auto& some : bytes) size += some.size();
    file.reserve(size + 2);
    for (const auto& some : bytes) file.insert(file.end(), some.begin(), some.end());
}

}  // namespace hexrelief::exporters
