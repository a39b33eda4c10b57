#include "pipeline/job/run_files.h"

#include <algorithm>
#include <iterator>
#include <optional>

#include "exporters/core/mesh_format.h"
#include "exporters/images/texture.h"
#include "exporters/viewer/html_exporter.h"
#include "pipeline/config/fields.h"
#include "pipeline/data/error.h"
#include "pipeline/data/number_text.h"
#include "pipeline/files/make_rule.h"
#include "pipeline/files/output_set.h"
#include "pipeline/job/input.h"
#include "pipeline/job/outputs.h"
#include "pipeline/job/pairs/working_size.h"
#include "pipeline/job/pictures/stage_pictures.h"
#include "pipeline/readers/cameras/calibration_reader.h"
#include "pipeline/readers/decoded_raster.h"

namespace hexrelief::job {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const std::string& what) {
    throw Error(ErrorKind::usage, what);
}

int files_for_standard_output(const RunRequest& request) {
    return static_cast<int>(files::is_standard_output(request.report) +
                            std::ranges::count_if(request.outputs, files::is_standard_output));
}

// Throws Error(usage) unless at most one file goes to the standard output.
void check_standard_output(const RunRequest& request) {
    for (const fs::path& output : request.outputs) {
        if (!files::is_standard_output(output)) continue;
        if (planned_files(output, request.config.exporting).size() > 1)
            refuse("the standard output takes one file, and " + exporters::export_format(output).name() +
                   " may have several; use -o - for .glb, or one of " + standard_output_names() +
                   ", without export.lod");
    }
    if (files_for_standard_output(request) > 1)
        refuse("the standard output takes one file: give '-' once, as an output or as the report");
}

// The system takes a name for shorter than it is if it holds a byte of 0, which the library can be given.
void check_names(const RunRequest& request) {
    std::vector<fs::path> names = read_files(request);
    names.insert(names.end(), request.outputs.begin(), request.outputs.end());
    names.insert(names.end(), {request.report, request.depfile, request.stages_folder});
    for (const fs::path& name : names)
        if (name.native().find('\0') != std::string::npos)
            refuse(std::string("the name '") + name.c_str() +
                   "' goes on behind a byte of 0; no file has such a name");
}

// True if the run may rectify its pair, which only the calibration file's contents decide.
bool may_rectify(const RunRequest& request) {
    const bool is_pair = std::holds_alternative<PairFiles>(request.source) ||
                         std::holds_alternative<StereoFile>(request.source);
    return is_pair && !request.config.input.calibration.file.empty();
}

void check_collisions(const RunRequest& request) {
    const std::vector<WrittenFile> files = written_files(request);
    std::vector<files::FileIdentity> identities;
    for (const WrittenFile& file : files) identities.push_back(files::identify(file.path));
    for (std::size_t i = 0; i < files.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (identities[i] == identities[j] && !(files[i].is_texture && files[j].is_texture))
                refuse(files[j].purpose + " and " + files[i].purpose + " would be one file, " +
                       files[i].path.string() + "; choose another name");
    for (const fs::path& source : read_files(request)) {
        const files::FileIdentity identity = files::identify(source);
        for (std::size_t i = 0; i < files.size(); ++i)
            if (identities[i] == identity && !files[i].is_rectified)
                refuse(files[i].purpose + " would overwrite the input " + source.string() +
                       "; choose another name");
    }
}

// Return the files of each kind of source by role. Those that are not given are empty.
std::vector<InputFile> all_files(const PairFiles& pair) {
    return {{"left", pair.left}, {"right", pair.right}, {"mask", pair.mask}};
}
std::vector<InputFile> all_files(const StereoFile& stereo) {
    return {{"stereo", stereo.file}, {"mask", stereo.mask}};
}
template <typename Map>
std::vector<InputFile> all_files_of_map(const char* role, const Map& map) {
    return {{role, map.map}, {"color", map.color}, {"mask", map.mask}, {"confidence", map.confidence}};
}
std::vector<InputFile> all_files(const DisparityFiles& map) {
    std::vector<InputFile> files = all_files_of_map("disparity", map);
    files.push_back({"disparity right", map.right});
    files.push_back({"color right", map.color_right});
    return files;
}
std::vector<InputFile> all_files(const DepthFiles& map) {
    return all_files_of_map("depth", map);
}
template <typename Arrays>
std::vector<InputFile> all_files(const Arrays&) {
    return {};
}

constexpr std::uint64_t kBaseBytes = 40 << 20;
constexpr std::uint64_t kReducedPictureBytes = 12;  // per pixel of a picture whose pair is reduced

// Per pixel of a picture, mask or map of confidences beside the main input.
constexpr std::uint64_t kOtherBytes = 8;

struct MainInput {
    fs::path path;
    std::uint64_t width = 0, height = 0;  // 0 = the header cannot be read
    int reduced_by = 1;
    std::uint64_t other_pixels = 0;  // of the files beside it
};

// Returns what a file's header says; nothing if it cannot be read, which the run will report.
std::optional<readers::FileDescription> described(const RunRequest& request, const fs::path& path) {
    try {
        return readers::describe_raster(path, {}, request.config.limits.reading);
    } catch (const Error&) {
        return std::nullopt;
    }
}

struct OtherRaster {
    std::string path;
    std::uint64_t width, height;
};

// Returns the rasters beside the main input; a right picture is as large as the left one, and left out.
std::vector<OtherRaster> other_rasters(const RunRequest& request) {
    std::vector<OtherRaster> rasters;
    const std::vector<InputFile> files = files_of(request.source);
    for (std::size_t i = std::holds_alternative<PairFiles>(request.source) ? 2 : 1; i < files.size(); ++i)
        if (const auto raster = described(request, files[i].path))
            rasters.push_back({files[i].path, static_cast<std::uint64_t>(raster->width),
                               static_cast<std::uint64_t>(raster->height)});
    return rasters;
}

// Returns the number by which the source's pair is reduced. The layout of a file with two views is not known
// here: the estimate is the least of those that it may have.
int reduction_of(const Source& source, int width, int height, int working_px) {
    const auto [shorter, longer] = std::minmax(width, height);
    if (std::holds_alternative<PairFiles>(source)) return reduction_to(working_px, longer);
    if (std::holds_alternative<StereoFile>(source))
        return reduction_to(working_px, std::max(shorter, longer / 2));
    return 1;
}

MainInput main_input(const RunRequest& request) {
    const std::vector<InputFile> files = files_of(request.source);
    if (files.empty()) return {};
    MainInput input{files.front().path};
    if (const auto raster = described(request, input.path)) {
        input.width = static_cast<std::uint64_t>(raster->width);
        input.height = static_cast<std::uint64_t>(raster->height);
        input.reduced_by =
            reduction_of(request.source, raster->width, raster->height, request.config.disparity.working_px);
    }
    for (const auto& [file, width, height] : other_rasters(request)) input.other_pixels += width * height;
    return input;
}

// Refuses files that are large, larger than the main input, and of another shape, before they are decoded.
// The run compares the sizes of all others exactly.
void check_shapes(const RunRequest& request) {
    constexpr std::uint64_t small = 1 << 24, most_times = 16;
    if (std::holds_alternative<StereoFile>(request.source)) return;  // two views of any layout
    for (const auto& [file, width, height] : other_rasters(request)) {
        if (width * height <= small) continue;
        const MainInput input = main_input(request);
        if (input.width == 0 || width * height <= most_times * input.width * input.height) continue;
        const double aspect = static_cast<double>(input.width) / static_cast<double>(input.height);
        const double here = static_cast<double>(width) / static_cast<double>(height);
        const auto are_alike = [](double p, double q) { return p < 1.1 * q && q < 1.1 * p; };
        if (are_alike(here, aspect) || are_alike(1 / here, aspect)) continue;  // it may have to be turned
        throw Error(ErrorKind::input, file + ": it has " + size_text(width, height) + " px, but " +
                                          input.path.string() + " " + size_text(input.width, input.height) +
                                          "; both must show the left view, with the same aspect");
    }
}

std::uint64_t memory_for(const MainInput& input, const config::Config& config) {
    const double spacing = config.mesh.spacing_px, bytes_per_pixel = 100 + 1800 / (spacing * spacing);
    const std::uint64_t pixels = input.width * input.height;
    const std::uint64_t meshed = pixels / input.reduced_by / input.reduced_by;
    return kBaseBytes + static_cast<std::uint64_t>(static_cast<double>(meshed) * bytes_per_pixel) +
           (input.reduced_by > 1 ? kReducedPictureBytes * pixels : 0) + kOtherBytes * input.other_pixels;
}

// Throws Error(input) if the estimate exceeds limits.max_memory.
void check_memory(const RunRequest& request) {
    const auto limit = static_cast<std::uint64_t>(request.config.limits.max_memory);
    if (limit == 0) return;
    const MainInput input = main_input(request);
    const std::uint64_t needed = memory_for(input, request.config);
    if (needed <= limit) return;
    throw Error(ErrorKind::input, input.path.string() + ": its " + size_text(input.width, input.height) +
                                      " px" + (input.other_pixels > 0 ? ", and what goes with them," : "") +
                                      " are estimated to take " + std::to_string(needed) +
                                      " bytes of memory, more than the limit of " + std::to_string(limit) +
                                      " (limits.max_memory); scale it down, or raise the limit");
}

}  // namespace

std::string depfile_rule(const RunRequest& request) {
    std::vector<fs::path> targets;
    for (const fs::path& output : request.outputs)
        if (!files::is_standard_output(output)) targets.push_back(output);
    return files::make_rule(targets, read_files(request));
}

std::string standard_output_names() {
    std::string names;
    for (const exporters::MeshFormat* format : exporters::mesh_formats())
        if (!format->companion) names.append(names.empty() ? "" : ", ").append(format->name()).append(":-");
    return names;
}

bool writes_standard_output(const RunRequest& request) {
    return files_for_standard_output(request) > 0;
}

std::string levels_inside_warning(const RunRequest& request) {
    const exporters::ExportConfig& config = request.config.exporting;
    if (config.lod == 1 || config.lod_storage != exporters::LevelStorage::inside) return {};
    for (const fs::path& output : request.outputs)
        if (exporters::export_format(output).levels == exporters::LevelSupport::by_config)
            return "Blender, and other programs that do not know MSFT_lod, show all levels of detail of " +
                   output.string() + " on top of each other; export.lod_storage: files writes a file each";
    return {};
}

std::vector<fs::path> planned_files(const fs::path& path, const exporters::ExportConfig& config) {
    std::vector<fs::path> files;
    const exporters::MeshFormat& format = exporters::export_format(path);
    const int levels = format.has_separate_levels(config) ? config.lod : 1;
    for (int level = 0; level < levels; ++level) {
        files.push_back(level == 0 ? path : exporters::level_path(path, level));
        fs::path companion = files.back();
        if (!format.companion) continue;
        files.push_back(companion.replace_extension(format.companion));
        for (const std::string& type : exporters::texture_types(config.texture))
            files.push_back(exporters::texture_path(companion, type));
    }
    return files;
}

std::vector<WrittenFile> written_files(const RunRequest& request) {
    std::vector<WrittenFile> files;
    for (const fs::path& output : request.outputs)
        for (const fs::path& file : planned_files(output, request.config.exporting)) {
            const char* const companion = exporters::export_format(output).companion;
            const bool is_texture =
                companion && file.extension() != output.extension() && file.extension() != companion;
            files.push_back(
                {file, (file == output ? "the output " : "what goes with the output ") + output.string(),
                 is_texture});
        }
    if (!request.report.empty()) files.push_back({request.report, "the report"});
    if (!request.depfile.empty()) files.push_back({request.depfile, "the rule for make"});
    if (!request.stages_folder.empty()) {
        const std::string folder = request.stages_folder.string();
        for (const fs::path& name : stage_file_names())
            files.push_back({request.stages_folder / name, "a stage's result in " + folder});
        if (may_rectify(request))
            for (const fs::path& name : rectified_file_names())
                files.push_back({request.stages_folder / name, "the rectified pair in " + folder,
                                 /*is_texture=*/false, /*is_rectified=*/true});
    }
    std::erase_if(files, [](const WrittenFile& file) { return files::is_standard_output(file.path); });
    return files;
}

std::vector<InputFile> files_of(const Source& source) {
    std::vector<InputFile> files = std::visit([](const auto& given) { return all_files(given); }, source);
    std::erase_if(files, [](const InputFile& file) { return file.path.empty(); });
    return files;
}

std::vector<InputFile> input_files(const RunRequest& request) {
    std::vector<InputFile> files = files_of(request.source);
    for (const config::Field& field : config::config_fields()) {
        if (field.type != config::FieldType::file) continue;
        const std::string path = std::get<std::string>(field.get(request.config)),
                          section = config::section_of(field.path);
        const std::string& named = field.path.ends_with("file") ? section : field.path;
        if (!path.empty()) files.push_back({named.substr(named.rfind('.') + 1), path});
    }
    // The file beside a calibration is read if it is needed.
    const config::CalibrationConfig& calibration = request.config.input.calibration;
    if (!calibration.file.empty() && calibration.second_file.empty())
        if (const fs::path other = readers::find_other_file(calibration.file); !other.empty())
            files.push_back({"calibration", other.string()});
    return files;
}

std::vector<fs::path> read_files(const RunRequest& request) {
    std::vector<fs::path> files;
    for (const InputFile& file : input_files(request)) files.emplace_back(file.path);
    std::ranges::copy(request.config_files, std::back_inserter(files));
    return files;
}

std::uint64_t estimated_memory(const RunRequest& request) {
    return memory_for(main_input(request), request.config);
}

void check_request(const RunRequest& request) {
    if (request.outputs.empty() && request.stages_folder.empty() && request.report.empty())
        refuse("no output: give -o FILE, --save-stages DIR or --report FILE");
    if (request.outputs.empty() && request.config.budget.max_bytes > 0)
        refuse("--max-bytes (budget.max_bytes) limits mesh files, and there is none; give -o FILE");
    if (has_page(request.outputs) && !exporters::has_viewer())
        refuse(std::string("no page can be written: ") + exporters::kNoViewer);
    check_names(request);
    check_standard_output(request);
    check_collisions(request);
    for (const fs::path& output : request.outputs)
        if (!files::is_standard_output(output))
            for (const fs::path& file : planned_files(output, request.config.exporting))
                files::check_writable_file(file);
    if (!request.report.empty() && !files::is_standard_output(request.report))
        files::check_writable_file(request.report);
    if (!request.depfile.empty()) {
        static_cast<void>(depfile_rule(request));  // names that make cannot hold
        files::check_writable_file(request.depfile);
    }
    if (!request.stages_folder.empty()) files::check_writable_folder(request.stages_folder);
    check_shapes(request);
    check_memory(request);
}

}  // namespace hexrelief::job
