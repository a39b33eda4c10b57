// The entropy coding of baseline JPEG files (ITU-T T.81, annexes F.1.2 and K.2), in parts by several threads.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/base/thread_pool.h"

namespace hexrelief::exporters {

// Brightness has the first table of each class, colours share the second.
inline constexpr std::size_t kJpegTables = 2, kJpegSymbols = 256;

// The symbols of consecutive blocks, which any code can write.
class JpegSymbols {
  public:
    // Codes that there may be: of a table's DC symbols, of its AC symbols, of the next table's.
    static constexpr std::size_t kCodes = kJpegTables * 2 * kJpegSymbols;

    // Expects so many blocks.
    explicit JpegSymbols(std::size_t blocks);
    // Appends a block of 64 quantised coefficients, row by row, of component 0..2. Throws Error(output) if a
    // file cannot hold one, as follow() does.
    void add(std::size_t component, const std::int16_t* block);
    // Appends a block that completes a unit at the picture's border: the block before it without detail.
    void add_border(std::size_t component);
    // Completes the symbols by the blocks before these; to be called once, front to back.
    void follow(const JpegSymbols* before);

    const std::vector<std::uint32_t>& items() const { return items_; }
    const std::array<std::uint32_t, kCodes>& counts() const { return counts_; }
    // The code of an item, the number of bits that follow it, and these bits.
    static std::size_t code_of(std::uint32_t item) { return item >> 16; }
    static int extra_bits_of(std::size_t code) { return static_cast<int>(code & 15); }
    static std::uint32_t extra_of(std::uint32_t item) { return item & 0xffff; }

  private:
    struct Component {
        bool has_blocks = false;
        std::size_t first_item = 0;
        int first_dc = 0, last_dc = 0;
    };

    void append(std::size_t table, std::size_t symbol, std::uint32_t extra);

    std::vector<std::uint32_t> items_;
    std::array<std::uint32_t, kCodes> counts_ = {};
    std::array<Component, 3> components_;
};

// An optimal Huffman code of symbols.
struct JpegCode {
    std::array<std::uint8_t, 17> lengths = {};  // number of codes of each length in bits, from 1 on
    std::vector<std::uint8_t> symbols;          // by length, then by value
};
// counts: of kJpegSymbols symbols.
JpegCode optimal_jpeg_code(const std::uint64_t* counts);

// The codes of DC and AC symbols of each table, in the order of JpegSymbols::kCodes.
using JpegCodes = std::array<JpegCode, 2 * kJpegTables>;
JpegCodes optimal_jpeg_codes(const std::vector<JpegSymbols>& parts);

// Appends the parts' symbols as the data of one scan to `file`.
void append_jpeg_scan(std::vector<std::uint8_t>& file, const std::vector<JpegSymbols>& parts,
                      const JpegCodes& codes, ThreadPool& pool);

}  // namespace hexrelief::exporters
