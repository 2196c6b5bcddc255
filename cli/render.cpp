// `stratus render`: renders a scene to a picture, or a figure.
#include <stratus/scene/render.h>

#include <stratus/bake/parallel.h>
#include <stratus/base/argument.h>
#include <stratus/base/number_text.h>
#include <stratus/base/size.h>
#include <stratus/picture/png.h>
#include <stratus/scene/plan.h>

#include "options.h"
#include "progress.h"

#include <system_error>
#include <utility>

namespace stratus {
namespace {

struct RenderCommand {
    std::string scene;
    std::vector<std::string> tables, outputs;
    std::string effects, drop, frames;
    CacheOptions cache;
    int width = 0, threads = 0;
    bool quiet = false;
    ReadOptions reading;
};

/// Frames to render: A:B, both included, or the first of a film without --frames.
struct FrameRange {
    int first = 0, last = 0;
};

FrameRange read_frames(const std::string& text, int count) {
    FrameRange range;
    if (text.empty()) return range;
    const char* const end = text.data() + text.size();
    const auto [colon, first_error] = std::from_chars(text.data(), end, range.first);
    const auto [rest, error] = std::from_chars(std::min(colon + 1, end), end, range.last);
    const bool read = first_error == std::errc() && colon != end && *colon == ':' &&
                      error == std::errc() && rest == end;
    require(read && 0 <= range.first && range.first <= range.last && range.last < count, "render",
            "--frames", "A:B, frames from A to B within 0:" + std::to_string(count - 1), text);
    return range;
}

/// The file of a frame, whose number stands in place of %d or %04d.
std::string name_of_frame(const std::string& pattern, int frame) {
    const std::size_t begin = pattern.find('%');
    std::size_t end = begin == pattern.npos ? begin : begin + 1;
    std::size_t digits = 0;
    if (end < pattern.size() && pattern[end] == '0') {
        digits = end + 1 < pattern.size() ? size(pattern[end + 1] - '0') : 0;
        end += 2;
    }
    require(end < pattern.size() && pattern[end] == 'd' && digits < 10 &&
                pattern.find('%', end) == pattern.npos,
            "render", "--output", "a name with one %d, or %04d, where --frames is given", pattern);
    const std::string number = std::to_string(frame);
    return pattern.substr(0, begin) + std::string(digits - std::min(digits, number.size()), '0') +
           number + pattern.substr(end + 1);
}

std::string frame_output(const RenderCommand& command, const std::string& output, int frame) {
    return command.frames.empty() ? output : name_of_frame(output, frame);
}

void check_outputs(const RenderCommand& command, const FrameRange& frames) {
    std::vector<std::string> inputs = command.tables;
    inputs.push_back(command.scene);
    for (const std::string& each : command.outputs)
        for (int frame = frames.first; frame <= frames.last; ++frame) {
            const std::string output = frame_output(command, each, frame);
            require_writable("render", "--output", output, {".png", ".exr", ".svg"});
            require_different_files("render", inputs, {output});
        }
}

void require_ending(const std::string& output, bool svg) {
    if ((fs::path(output).extension() == ".svg") == svg) return;
    throw std::invalid_argument(std::string("render: --output must end in ") +
                                (svg ? ".svg for figures" : ".png or .exr for pictures") +
                                ", got " + output);
}

SceneTables tables_for(const RenderCommand& command, const Scenes& scenes, TableCache* cache,
                       Progress& progress) {
    if (!command.tables.empty()) {
        std::vector<PackedTable> tables;
        for (const std::string& table : command.tables)
            tables.push_back(read_packed_table(table, command.reading));
        return adopt_tables(scenes, std::move(tables));
    }
    BakeOptions options;
    options.threads = command.threads;
    options.progress = std::ref(progress);
    auto tables = bake_for(scenes, options, cache);
    if (cache && !cache->trouble().empty())
        progress.note("note: tables are not kept: " + cache->trouble());
    return tables;
}

/// The title of each panel, in its lower left corner.
std::vector<Label> panel_labels(const SceneFile& file) {
    std::vector<Label> labels;
    if (file.panels.size() < 2) return labels;
    for (std::size_t k = 0; k < file.panels.size(); ++k) {
        const Scene& panel = file.panels[k];
        const int column = static_cast<int>(k) % file.columns,
                  row = static_cast<int>(k) / file.columns;
        labels.push_back({column * panel.width + 10.0, (row + 1) * panel.height - 12.0,
                          panel.width - 20.0, panel.title});
    }
    return labels;
}

/// The effects as --effects takes them; panel by panel where they differ.
std::string effects_text(const SceneFile& file) {
    std::vector<std::string> texts;
    for (const Scene& panel : file.panels)
        texts.push_back(joined(scene_effect_names(panel.effects), ","));
    const bool alike = std::ranges::count(texts, texts[0]) == std::ssize(texts);
    return alike ? texts[0] : joined(texts, "; ");
}

bool has_one_white(const SceneFile& file) {
    return std::ranges::all_of(
        file.panels, [&](const Scene& panel) { return panel.white == file.panels[0].white; });
}

/// picture.white of the panel that holds a pixel.
double white_at(const SceneFile& file, const Image& image, int x, int y) {
    const Scene& first = file.panels[0];
    const int panel = y / first.height * (image.width / first.width) + x / first.width;
    return file.panels[std::min(size(panel), file.panels.size() - 1)].white;
}

/// The picture with each panel as bright over the first one's white as it is over its own.
Image over_first_white(const SceneFile& file, Image image) {
    const double first = file.panels[0].white;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x)
            if (const double white = white_at(file, image, x, y); white != first)
                for (int c = 0; c < 3; ++c) {
                    float& light = image.pixel(x, y)[c];
                    light = static_cast<float>(light * (first / white));
                }
    return image;
}

void write_picture(const SceneFile& file, const Image& image, const std::string& output) {
    const bool png = fs::path(output).extension() == ".png";
    write_file(output, [&](const fs::path& temporary) {
        if (png)
            write_png(over_first_white(file, image), file.panels[0].white, panel_labels(file),
                      temporary);
        else
            write_exr_image(image,
                            {{"title", file.title},
                             {"scene", file.text},
                             {"effects", effects_text(file)},
                             {"radiance", "relative to a white Lambert surface facing the sun"},
                             {"program_version", STRATUS_VERSION}},
                            temporary);
    });
}

/// Leaves out what the plans do, and says so.
void leave_out_by_plans(Film& film, Progress& progress) {
    const std::vector<Plan> plans = follow_plans(film);
    for (std::size_t k = 0; k < plans.size(); ++k)
        for (const LeftOut& effect : plans[k].left_out)
            progress.note("plan: " + panel_name(film[0], k) + ": without " + effect.name +
                          ", which changes about " + short_number(effect.change.change, 2) +
                          " of any light at most, by an estimate");
}

/// Tells of a picture without light, and of a PNG that cannot show most of it.
void note_exposure(const RenderCommand& command, const SceneFile& file, const Image& image,
                   Progress& progress) {
    std::size_t lit = 0, clipped = 0;
    double brightest = 0;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const float* const pixel = image.pixel(x, y);
            const double light = double{*std::max_element(pixel, pixel + 3)};
            brightest = std::max(brightest, light);
            lit += light > 0;
            clipped += light > white_at(file, image, x, y);
        }
    if (lit == 0) progress.note("note: all of the picture is black");
    const bool has_png = std::ranges::any_of(command.outputs, [](const std::string& output) {
        return fs::path(output).extension() == ".png";
    });
    if (has_png && 2 * clipped > lit)
        progress.note(
            "note: " +
            short_number(100 * static_cast<double>(clipped) / static_cast<double>(lit), 3) +
            " % of all lit pixels are brighter than picture.white" +
            (has_one_white(file) ? ", " + short_number(file.panels[0].white, 3) + ","
                                 : " of their panel") +
            " and clipped; the brightest has " + short_number(brightest, 3));
}

/// Renders frames of a film, or a picture, with tables that serve every frame: each is the same whichever
/// others are rendered.
void run_pictures(const RenderCommand& command, Film& film, const FrameRange& frames,
                  TableCache* cache, Progress& progress) {
    change({split(command.effects), split(command.drop), command.width}, film);
    const auto started = Clock::now();
    // A table that is there saves nothing by what is not looked up in it.
    if (command.effects.empty() && command.tables.empty()) leave_out_by_plans(film, progress);
    const auto tables = tables_for(command, all_panels(film), cache, progress);
    const double baked = seconds_since(started);
    const int count = frames.last - frames.first + 1;
    for (int k = frames.first; k <= frames.last; ++k) {
        const SceneFile& file = film[size(k)];
        RenderOptions options;
        options.threads = command.threads;
        options.progress = [&](double done, const std::string& stage) {
            progress((k - frames.first + done) / count, stage);
        };
        const Image image = render(film, k, tables, options);
        for (const std::string& output : command.outputs)
            write_picture(file, image, frame_output(command, output, k));
        if (k == frames.first) note_exposure(command, file, image, progress);
        if (k < frames.last) continue;
        progress.note(formatted("%s%d x %d pixels; tables %.2f s, all %.2f s",
                                count > 1 ? (std::to_string(count) + " frames of ").c_str() : "",
                                image.width, image.height, baked, seconds_since(started)));
    }
}

void run_figure(const RenderCommand& command, const SceneFile& file, Progress& progress) {
    for (const auto& [option, given] :
         {std::pair("--frames", !command.frames.empty()),
          std::pair("--table", !command.tables.empty()),
          std::pair("--effects", !command.effects.empty()),
          std::pair("--drop", !command.drop.empty()), std::pair("--width", command.width != 0)})
        if (given)
            throw std::invalid_argument(std::string("render: ") + option +
                                        " must not be given for figures, got one");
    const auto started = Clock::now();
    auto write = [&](const auto& draw) {
        for (const std::string& output : command.outputs) write_file(output, draw);
    };
    double error = 0;
    if (const auto* const lobes = std::get_if<LobeFigure>(&*file.figure)) {
        const LobePlot plot = plot_lobes(*lobes);
        error = plot.error;
        write([&](const fs::path& svg) { draw_lobe_plot(plot, svg); });
    } else {
        const LambertComparison made = compare_with_lambert(std::get<LambertFigure>(*file.figure));
        error = made.error;
        write([&](const fs::path& svg) { draw_line_plot(made.plot, svg); });
        std::printf(
            "largest deviation from Lambert's law, for mu of at least 0.2: %.3g at mu_in = %.3g, "
            "mu = "
            "%.3g (mean over azimuths); %.3g at mu = %.3g on the disk at full phase\n",
            made.deviation, made.mu_in, made.mu, made.disk_deviation, made.disk_mu);
    }
    progress.note("the solver's relative error, estimated: " + short_number(error, 2));
    progress.note(short_number(seconds_since(started), 2) + " s");
}

void run_render(const RenderCommand& command) {
    if (command.frames.empty()) check_outputs(command, {});
    std::vector<std::string> notes;
    const std::unique_ptr<TableCache> cache = open_cache(command.cache);
    Film film = read_film(command.scene, &notes);
    const bool is_figure = film[0].figure.has_value();
    for (const std::string& output : command.outputs) require_ending(output, is_figure);
    Progress progress(command.quiet);
    progress.notes(notes);
    if (is_figure) return run_figure(command, film[0], progress);
    const FrameRange frames = read_frames(command.frames, film[0].frames);
    if (command.frames.empty() && film.size() > 1)
        progress.note("note: this is frame 0 of " + std::to_string(film.size()) +
                      "; --frames renders others");
    check_outputs(command, frames);
    run_pictures(command, film, frames, cache.get(), progress);
}

}  // namespace

void add_render(CLI::App& app) {
    const auto [command, options] = add_command<RenderCommand>(
        app, "render", "Render a scene: rings, a planet, clouds, or a figure", run_render);
    add_file(command, "SCENE", options.scene, "Scene, .toml")->required();
    add_file(command, "-o,--output", options.outputs,
             "Picture to write, .png or .exr; may be repeated; for figures, .svg")
        ->required()
        ->allow_extra_args(false);
    add_file(command, "--table", options.tables,
             "Table to look up instead of baking, .h5, .exr or .stratus; as often as `stratus "
             "plan` has recipes, for light paths or colours with tables of their own, or "
             "fewer that serve several")
        ->allow_extra_args(false);
    add_text(command, "--frames", options.frames, "frames, as A:B",
             "Frames A to B of the scene's [animation], as A:B; the output's name has their "
             "number in place of %d, or %04d. Default: the first alone");
    add_max_memory(command, options.reading);
    std::string names;
    for (const auto& effect : scene_effects()) names += std::string(", ") + effect.first;
    add_text(command, "--effects", options.effects, "names of effects",
             "Effects, instead of the scene's own: all" + names + "; -NAME switches one off");
    add_drop(command, options.drop);
    add_cache(command, options.cache);
    add_width(command, options.width);
    add_threads(command, options.threads);
    add_quiet(command, options.quiet);
    add_keys(command, "scenes", scene_keys());
    command.footer(
        "PNG files show radiance L as sRGB(min(L / white, 1)), EXR files hold L itself: relative\n"
        "to that of a white Lambert surface facing the sun.\n"
        "What is estimated to change no light by more than half the scene's tolerance is left out, "
        "unless --effects "
        "or the scene names it; `stratus plan` tells more. Tables are kept for the next picture in "
        "$STRATUS_CACHE, $XDG_CACHE_HOME/stratus or ~/.cache/stratus.\n"
        "Example:\n  stratus render tables/scenes/saturn_lit.toml -o saturn.png -o saturn.exr "
        "--width 512\n  stratus render film.toml --frames 0:99 -o frame_%04d.png");
}

}  // namespace stratus
