#include <algorithm>
#include <optional>
#include <string_view>

#include "pipeline/batch/manifest_rows.h"
#include "pipeline/data/error.h"

namespace hexrelief::batch {
namespace {

struct CsvRecord {
    int line = 0;  // of its first cell
    std::vector<std::string> cells;
    bool is_closed = true;  // false: a quote was opened and never closed
};

class CsvReader {
  public:
    explicit CsvReader(std::string_view text) : rest_(text) {
        if (rest_.starts_with("\xef\xbb\xbf")) rest_.remove_prefix(3);  // a byte order mark
    }

    // Returns the next record, skipping empty lines; nothing at the end.
    std::optional<CsvRecord> next() {
        while (!rest_.empty() && (rest_.front() == '\n' || rest_.front() == '\r')) take();
        if (rest_.empty()) return std::nullopt;
        CsvRecord record{line_, {}, true};
        do {
            record.cells.push_back(cell(record.is_closed));
        } while (took(','));
        took('\r');
        took('\n');
        return record;
    }

  private:
    char take() {
        const char first = rest_.front();
        rest_.remove_prefix(1);
        line_ += first == '\n';
        return first;
    }
    bool took(char wanted) {
        if (!rest_.starts_with(wanted)) return false;
        take();
        return true;
    }
    std::string cell(bool& is_closed) {
        std::string text;
        if (!took('"')) {
            while (!rest_.empty() && std::string_view(",\r\n").find(rest_.front()) == std::string_view::npos)
                text += take();
            return text;
        }
        for (;;) {
            if (rest_.empty()) {
                is_closed = false;
                return text;
            }
            const char letter = take();
            if (letter == '"' && !took('"')) return text;
            text += letter;
        }
    }

    std::string_view rest_;
    int line_ = 1;
};

}  // namespace

std::vector<ManifestRow> csv_rows(const std::string& text, const std::string& origin) {
    CsvReader reader(text);
    const std::optional<CsvRecord> header = reader.next();
    if (!header || !header->is_closed)
        throw Error(ErrorKind::usage, origin + ": its first line has to name the columns: left,right,...");
    std::vector<ManifestRow> rows;
    while (const std::optional<CsvRecord> record = reader.next()) {
        ManifestRow row{origin + ":" + std::to_string(record->line), {}, {}};
        const std::size_t cells = record->cells.size(), columns = header->cells.size();
        if (!record->is_closed)
            row.wrong = "a quote is opened and never closed";
        else if (cells > columns)
            row.wrong = std::to_string(cells) + " cells, but the header names " + std::to_string(columns);
        for (std::size_t i = 0; i < std::min(cells, columns); ++i)
            if (!record->cells[i].empty()) row.values.emplace_back(header->cells[i], record->cells[i]);
        rows.push_back(std::move(row));
    }
    return rows;
}

}  // namespace hexrelief::batch
