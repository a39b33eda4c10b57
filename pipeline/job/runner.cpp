#include "pipeline/job/runner.h"

#include <algorithm>
#include <cstdint>
#include <future>
#include <limits>
#include <string>
#include <utility>

#include "exporters/images/picture_file.h"
#include "exporters/images/texture.h"
#include "pipeline/checks/checks.h"
#include "pipeline/checks/map_statistics.h"
#include "pipeline/checks/pair_statistics.h"
#include "pipeline/data/error.h"
#include "pipeline/data/start_work.h"
#include "pipeline/files/output_set.h"
#include "pipeline/files/sha256.h"
#include "pipeline/job/disparities.h"
#include "pipeline/job/input.h"
#include "pipeline/job/maps/disparity_input.h"
#include "pipeline/job/outputs.h"
#include "pipeline/job/pairs/align_pair.h"
#include "pipeline/job/pairs/working_size.h"
#include "pipeline/job/right_view.h"
#include "pipeline/job/run_files.h"
#include "pipeline/job/surfaces.h"
#include "pipeline/readers/source.h"
#include "pipeline/stages/disparity.h"

namespace hexrelief::job {
namespace {

// True if the disparities are right in spite of this finding.
bool leaves_disparities(const checks::Finding& finding) {
    return finding.mistake == checks::Mistake::range_wide ||
           finding.mistake == checks::Mistake::range_ends_low ||
           finding.mistake == checks::Mistake::rows_differ ||
           finding.mistake == checks::Mistake::rows_flipped ||
           finding.mistake == checks::Mistake::color_mirrored ||
           finding.mistake == checks::Mistake::color_elsewhere ||
           finding.mistake == checks::Mistake::color_unrelated;
}

// Returns the share of the pixels that a mask keeps, above 0; 1 for an empty one.
double kept_share(const readers::PixelMask& mask) {
    if (mask.empty()) return 1;
    const auto kept = std::ranges::count(mask.kept, 1);
    return static_cast<double>(std::max<std::ptrdiff_t>(1, kept)) / static_cast<double>(mask.kept.size());
}

// Warns of likely mistakes in a pair or a map, its picture or its camera. range: the range found for a pair.
// Throws Error(input) with the same text if run.strict is set.
void check_input(const RunInput& input, const stages::FoundRange& range, const config::Config& config,
                 int threads, RunLog& log) {
    const InputPair* const pair = input.pair();
    const InputMap* const map = input.map();
    // The matcher refuses a blank picture; any other finding would be spurious.
    if (pair && (checks::is_blank(pair->views.left) || checks::is_blank(pair->views.right))) return;
    const bool is_depth = map && map->is_depth;
    std::vector<checks::Finding> findings;
    if (pair) {
        const stages::DisparityConfig& searched = range.config;
        findings = checks::check_pair(pair->views, range.coarse,
                                      {searched.min_disparity_px, searched.num_disparities_px}, range.origin,
                                      kept_share(pair->right_mask), threads);
    } else {
        const readers::DisparityFileConfig& file = config.input.disparity;
        findings = checks::check_map(map->disparities, map->color,
                                     is_depth ? checks::MapKind::depth : checks::MapKind::disparity,
                                     {file.scale > 0 ? file.scale : 1, file.offset_px});
    }
    double median_px = std::numeric_limits<double>::quiet_NaN();
    if (input.calibration.metric && std::ranges::all_of(findings, leaves_disparities))
        median_px = pair ? checks::median_disparity_px(range.coarse)
                         : checks::measure_values(map->disparities).median_px;
    for (checks::Finding& finding : is_depth ? checks::check_depths(input.calibration, median_px)
                                             : checks::check_camera(input.calibration, median_px))
        findings.push_back(std::move(finding));
    for (checks::Finding& finding : checks::check_focal(input.calibration))
        findings.push_back(std::move(finding));
    for (const checks::Finding& finding : findings) {
        if (config.run.strict) throw Error(ErrorKind::input, finding.text);
        log.warn(finding.text);
    }
}

// A device's driver starts in a thread of its own even if the job has one thread, because it mostly waits.
constexpr int kWithDriver = 2;

int threads_for(const config::Config& config, const RunLog& log) {
    const int threads = effective_threads(config.run.threads);
    if (threads < config.run.threads)
        log.decide("threads: " + std::to_string(threads) + " in place of " +
                   std::to_string(config.run.threads) + ": more would wait for each other");
    return threads;
}

// Returns the file of the left picture if the texture may keep something of it; else nothing.
std::vector<std::uint8_t> picture_file_of(const RunInput& input, const config::Config& config) {
    const auto file = std::ranges::find_if(input.files, [](const InputFile& f) {
        return f.role == "left" || f.role == "stereo" || f.role == "color";
    });
    if (file == input.files.end()) return {};
    constexpr std::size_t kHead = 12;
    const readers::codec::SourceFile head = readers::codec::open_file(file->path, kHead);
    if (!exporters::may_keep(config.exporting.texture, exporters::image_type(head.bytes))) return {};
    const std::size_t most = 2 * input.texture().pixels.size();  // both views of one file, hardly compressed
    if (head.size() > most) return {};
    return readers::codec::load_file(file->path, most).bytes;
}

RunInput read_source(RunRequest& request, int threads, RunLog& log) {
    const std::vector<std::filesystem::path> files = read_files(request);
    const files::UnchangedFiles sources(files);
    RunInput input = read_input(std::move(request.source), request.config.input,
                                request.config.limits.reading, threads, log);
    input.texture_file = picture_file_of(input, request.config);
    reduce_pair(input, request.config.disparity, threads, log);
    if (input.pair() && input.pair()->is_rectified && !request.stages_folder.empty())
        for (const std::filesystem::path& name : rectified_file_names())
            files::check_overwrites({request.stages_folder / name}, files);
    sources.check();
    return input;
}

std::string reason_for(const Backend& backend, const BackendDecision& decision) {
    const bool missing = decision.choice == config::BackendChoice::automatic && backend.name() == "cpu";
    return decision.reason + (missing ? ", but none is usable" : "");
}

// Returns the started backend. Under auto the CPU replaces the device if the device fails.
BackendPointer take_backend(BackendPointer started, const config::Config& config, RunLog& log) {
    if (!started->missed.empty()) log.warn(going_on_without(started->missed));
    if (config.run.backend != config::BackendChoice::automatic || started->name() == "cpu") return started;
    const BackendPointer cpu =
        pick_backend(config::BackendChoice::cpu, started->threads(), config.mesh.method);
    return with_replacement(started, cpu, log);
}

}  // namespace

Relief make_disparities(RunRequest request, Backends& backends, RunLog& log) {
    const config::Config& config = request.config;
    if (const std::string told = levels_inside_warning(request); !told.empty()) log.warn(told);
    for (const std::string& decision : config.decisions) log.decide(decision);
    const int threads = threads_for(config, log);
    // A requested device starts while the files are read; a device that auto may choose starts once their
    // size is known, while the disparity range is searched for.
    const auto start = [&](config::BackendChoice choice) {
        return start_work(kWithDriver,
                          [&, choice] { return backends.get(choice, threads, config.mesh.method); });
    };
    std::future<BackendPointer> starting;
    if (config.run.backend != config::BackendChoice::automatic) starting = start(config.run.backend);
    Relief relief;
    RunInput& input = relief.input = log.stage("input", [&] { return read_source(request, threads, log); });
    InputPair* const pair = std::get_if<InputPair>(&input.views);
    const BackendDecision decision = choose_backend(
        {input.calibration.width, input.calibration.height, pair != nullptr, threads, request.jobs}, config);
    if (!starting.valid()) starting = start(decision.choice);
    stages::FoundRange range;
    StereoPair as_matched;
    if (pair)
        log.stage("range", [&] {
            const stages::DisparityConfig searched =
                pair->alignment
                    ? with_range_of(*pair->alignment, pair->views.left.width * pair->reduced_by, config)
                    : config.disparity;
            stages::DisparityConfig of_size = for_reduced(searched, pair->reduced_by);
            if (pair->is_of_points() && !config.given.contains("disparity.speckle_window_px"))
                of_size.speckle_window_px = largest_speckle_px(pair->views.left);
            range = stages::find_range(pair->views, input.calibration, of_size, threads);
            if (config.disparity.num_disparities_px == 0 && range.origin == stages::RangeOrigin::given)
                range.origin = stages::RangeOrigin::chosen;
            log.decide(range_text(range.config, range.origin));
            as_matched = stages::corrected(pair->views, range.correction, threads);
        });
    log.stage("checks", [&] { check_input(input, range, config, threads, log); });
    const BackendPointer started = log.stage("device", [&] { return starting.get(); });
    relief.backend_reason = reason_for(*started, decision);
    relief.backend = take_backend(started, config, log);
    log.decide("backend: " + relief.backend->name() + ", " + relief.backend_reason);
    if (InputMap* const map = std::get_if<InputMap>(&input.views)) {
        if (!map->right.values.empty() && config.surface.views == SurfaceViews::both && input.is_whole())
            relief.right =
                log.stage("right view", [&] { return supplied_right_view(*map, config, threads, log); });
        relief.disparity = log.stage(
            "disparity", [&] { return supplied_disparities(*map, input.mask, config, threads, log); });
    } else {
        std::optional<stages::ViewMaps> by_program;
        if (stages::gives_maps(range.config.method))
            by_program = log.stage("matcher", [&] {
                stages::ViewMaps maps = backends.programs().match(pair->views, range.config, threads, log);
                if (config.disparity.fill == stages::DisparityFill::planes)
                    sharpen_maps(maps, pair->views, threads, log);
                return maps;
            });
        relief.disparity = log.stage("disparity", [&] {
            DisparityResult matched =
                by_program ? disparities_of_program(pair->views, *by_program, range.config, threads)
                           : disparities_of_pair(*pair, as_matched, range.config, *relief.backend);
            hide(matched.map, input.mask);
            judge_support(matched, *pair, input.mask, config.run.strict, threads, log);
            return matched;
        });
        // Without filled pixels what only the right camera sees is unknown, as it has no match.
        if (config.surface.views == SurfaceViews::both && input.is_whole() &&
            (by_program || config.disparity.fill == stages::DisparityFill::planes))
            relief.right = log.stage("right view", [&] {
                return by_program ? right_view_of_program(*pair, *by_program, range, threads)
                                  : unmatched_right_view(*pair, range, threads);
            });
    }
    return relief;
}

Relief make_relief(RunRequest request, Backends& backends, RunLog& log) {
    config::Config config = request.config;
    const std::vector<std::filesystem::path> outputs = request.outputs;
    Relief relief = make_disparities(std::move(request), backends, log);
    Backend& backend = *relief.backend;
    const InputPair* const pair = relief.input.pair();
    finish_disparities(relief, config, log);
    relief.density = log.stage("density", [&] {
        return density_of(relief.disparity.meshed(), for_reduced(config.density, relief.input.reduced_by()),
                          backend.threads(), log);
    });
    const LeftView view = relief.view();
    if (relief.right)
        complete_right_view(*relief.right, relief.view(), relief.disparity,
                            pair ? pair->right_mask : readers::PixelMask{}, backend.threads());
    relief.surface = has_budget(config.budget) ? meet_budget(view, config, outputs, backend, log)
                                               : make_surface(view, config, backend, log);
    warn_of_inversions(relief.surface.quality, log);
    return relief;
}

RunReport write_relief(std::shared_ptr<const Relief> made, const RunRequest& request, RunLog& log) {
    const Relief& relief = *made;
    const SurfaceResult& surface = relief.surface;
    const LeftView view = relief.view();
    const int threads = relief.backend->threads();
    RunReport report{std::move(made), request.stamp};
    const bool with_page = has_page(request.outputs);
    // Measured while files are written, unless one is a page that tells the figures.
    std::future<void> measures;
    const bool is_measured = with_page || !request.report.empty();
    if (is_measured) measures = start_work(threads, [&] { take_measures(request.outputs, report); });
    const auto finish_measures = [&] {
        log.stage("measures", [&] { measures.get(); });
        tell_quality(report.quality, log);
    };
    if (with_page) finish_measures();
    if (surface.config.exporting.lod > 1)
        report.coarser =
            log.stage("levels", [&] { return coarser_levels(view, surface, *relief.backend, log); });

    files::OutputSet files;
    exporters::Scene scene = scene_of(view, surface, report.coarser);
    scene.threads = threads;
    exporters::PageContent page;
    if (with_page)
        page = log.stage("page", [&] { return page_content(view, surface, report.quality, threads); });
    scene.page = with_page ? &page : nullptr;
    auto shares = start_work(threads, [&] { return shares_of(relief); });
    report.outputs = log.stage(
        "export", [&] { return export_all(scene, surface.config.exporting, request.outputs, files, log); });
    if (is_measured && !with_page) finish_measures();
    if (!request.stages_folder.empty())
        log.stage("pictures", [&] {
            save_stages(view, surface, request.stages_folder, files, threads, log);
            if (const InputPair* const pair = relief.input.pair(); pair && pair->is_rectified)
                save_rectified(pair->views, relief.pair_camera, request.stages_folder, files);
        });
    report.shares = shares.get();
    take_figures(log, report);
    if (!request.depfile.empty()) files.write(request.depfile, depfile_rule(request));
    if (!request.report.empty()) files.write(request.report, report_json(report));
    files.commit();
    return report;
}

RunReport run_job(const RunRequest& request, Backends& backends, RunLog& log) {
    check_request(request);
    const auto relief = std::make_shared<const Relief>(make_relief(request, backends, log));
    std::future<void> giving_back;
    // Coarser levels still need the device when files are written.
    if (backends.ends_with_run() && relief->backend->name() != "cpu" &&
        relief->surface.config.exporting.lod == 1)
        giving_back = start_work(kWithDriver, [&] { relief->backend->give_back(); });
    return write_relief(relief, request, log);
}

RunReport run_job(const RunRequest& request) {
    Backends backends;
    RunLog log;
    return run_job(request, backends, log);
}

}  // namespace hexrelief::job
