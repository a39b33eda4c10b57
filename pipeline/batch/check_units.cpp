#include <map>

#include "pipeline/batch/batch.h"
#include "pipeline/config/presets.h"
#include "pipeline/data/error.h"
#include "pipeline/files/output_set.h"
#include "pipeline/job/run_files.h"

namespace hexrelief::batch {
namespace {

namespace fs = std::filesystem;

struct FileUser {
    std::size_t unit;
    bool is_read = false, is_written = false;
};

// Returns a path's plain name. Links are not followed, because a batch has some ten paths per row.
fs::path plain_name(const fs::path& path) {
    return fs::absolute(path).lexically_normal();
}

class Collisions {
  public:
    explicit Collisions(const std::vector<BatchUnit>& units) : units_(units) {}

    // Returns why the unit must not run beside those before it; empty if it may.
    std::string add(std::size_t unit, const job::RunRequest& request) {
        for (const job::WrittenFile& file : job::written_files(request))
            if (std::string why = use(file.path, {unit, false, true}); !why.empty()) return why;
        for (const fs::path& file : job::read_files(request))
            if (std::string why = use(file, {unit, true, false}); !why.empty()) return why;
        return {};
    }

  private:
    std::string use(const fs::path& file, const FileUser& user) {
        const auto [known, is_new] = users_.try_emplace(plain_name(file), user);
        if (is_new || known->second.unit == user.unit) return {};
        FileUser& other = known->second;
        const std::string& place = units_[other.unit].place;
        if (user.is_written && other.is_written)
            return file.string() + " is an output of " + place + ", too; choose another name";
        if (user.is_written || other.is_written)
            return file.string() + " is an input of one row and an output of another, " + place +
                   "; rows are done in any order";
        return {};
    }

    const std::vector<BatchUnit>& units_;
    std::map<fs::path, FileUser> users_;
};

}  // namespace

void check_units(std::vector<BatchUnit>& units, const RequestParser& parse) {
    Collisions collisions(units);
    for (std::size_t i = 0; i < units.size(); ++i) {
        BatchUnit& unit = units[i];
        if (!unit.wrong.empty()) continue;
        try {
            const job::RunRequest request = parse(unit.words);
            job::check_request(request);
            if (job::writes_standard_output(request))
                throw Error(ErrorKind::usage,
                            "a job of a batch cannot write to the standard output; name a file");
            unit.wrong = collisions.add(i, request);
        } catch (const Error& error) {
            unit.wrong = error.what();
            unit.kind = error.kind();
        }
    }
}

}  // namespace hexrelief::batch
