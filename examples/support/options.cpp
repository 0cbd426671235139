#include "support/options.hpp"

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <sstream>
#include <string_view>

#include "gmis/transport/plan/effect_switches.hpp"
#include "support/diagnostics.hpp"
#include "support/instruction_set.hpp"
#include "support/manual.hpp"

namespace gmis::tools {
namespace {

/// The integers of `text`, which stand between `separator`s; nothing when it is anything else.
template <std::size_t count>
std::optional<std::array<int, count>> integers_of(std::string_view text, char separator) {
  std::array<int, count> values{};
  const char* position = text.data();
  const char* const end = position + text.size();
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0 && (position == end || *position++ != separator)) return {};
    const auto [next, error] = std::from_chars(position, end, values[i]);
    if (error != std::errc{}) return {};
    position = next;
  }
  if (position != end) return {};
  return values;
}

/// Not read by CLI11, which lets negative numbers wrap around.
template <class Integer>
std::optional<Integer> integer_of(std::string_view text) {
  Integer value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return {};
  return value;
}

template <class Unsigned>
Unsigned whole_number_of(const std::string& option, std::string_view text, Unsigned least = 0) {
  const auto value = integer_of<Unsigned>(text);
  if (!value || *value < least)
    throw InputError(option + " " + in_quotes(text) + " must be a whole number from " + std::to_string(least) + " to " +
                     std::to_string(std::numeric_limits<Unsigned>::max()));
  return *value;
}

/// A part of a run, written FIRST..LAST/OF; nothing for a number alone.
std::optional<RunPart> run_part_of(std::string_view text) {
  const std::size_t dots = text.find(".."), slash = text.find('/');
  if (dots == std::string_view::npos) return {};
  const auto number = [&](std::size_t from, std::size_t to) {
    const auto value = integer_of<std::uint32_t>(text.substr(from, to - from));
    return value ? *value : 0U;
  };
  RunPart part{0, 0, 0};
  if (slash != std::string_view::npos && slash > dots)
    part = {number(0, dots), number(dots + 2, slash), number(slash + 1, text.size())};
  if (part.first < 1 || part.first > part.last || part.last > part.of)
    throw InputError("--iterations " + in_quotes(text) +
                     " must be FIRST..LAST/OF, iterations FIRST to LAST of a run of OF, such as 17..32/64");
  return part;
}

/// Nothing for `auto` and for `paired`.
std::optional<int> connections_of(const std::string& text) {
  if (text == "auto" || text == "paired") return {};
  const auto count = integer_of<int>(text);
  if (!count || *count < 1 || *count > 1000)
    throw InputError("--connections " + in_quotes(text) + " must be auto, paired or a whole number from 1 to 1000");
  return *count;
}

Scheme scheme_of(const std::string& name) {
  for (const Scheme scheme : all_schemes)
    if (name == gmis::name_of(scheme)) return scheme;
  throw InputError("--scheme " + in_quotes(name) + " is not known: use R1, R2, R3, N1, N2 or N3");
}

Emission emission_of(const std::string& name) {
  if (name == "power") return Emission::power;
  if (name == "learned") return Emission::learned;
  throw InputError("--emission " + in_quotes(name) + " is not known: use power or learned");
}

Sampler sampler_of(const std::string& name) {
  if (name == "independent") return Sampler::independent;
  if (name == "sobol") return Sampler::sobol;
  throw InputError("--sampler " + in_quotes(name) + " is not known: use independent or sobol");
}

scene::LightSelection lights_of(const std::string& name) {
  for (const auto lights :
       {scene::LightSelection::by_power, scene::LightSelection::by_receiver, scene::LightSelection::learned})
    if (name == name_of(lights)) return lights;
  throw InputError("--lights " + in_quotes(name) + " is not known: use power, receiver or learned");
}

std::array<int, 4> crop_of(const std::string& text) {
  const auto crop = integers_of<4>(text, ',');
  if (!crop || (*crop)[0] < 0 || (*crop)[1] < 0 || (*crop)[0] >= (*crop)[2] || (*crop)[1] >= (*crop)[3])
    throw InputError("--crop " + in_quotes(text) + " must be X0,Y0,X1,Y1 in pixels with X0 < X1 and Y0 < Y1");
  return *crop;
}

/// Names of integrators: "auto, bpt, vcm or gmis".
std::string names_of_those(bool (*is_meant)(IntegratorChoice)) {
  std::vector<std::string> names;
  if (is_meant(IntegratorChoice::automatic)) names.emplace_back(name_of(IntegratorChoice::automatic));
  for (const IntegratorChoice integrator : all_integrators)
    if (is_meant(integrator)) names.emplace_back(name_of(integrator));
  std::string text = names.front();
  for (std::size_t i = 1; i < names.size(); ++i) text += (i + 1 < names.size() ? ", " : " or ") + names[i];
  return text;
}

/// Throws for a given option that the integrator has no use for.
void refuse_idle_options(const Options& options, const std::function<bool(const char*)>& is_given) {
  struct Use {
    const char* option;
    bool (*has_use)(IntegratorChoice);
    const char* others;  ///< what the integrators without a use for it do
  };
  const std::string integrator = name_of(options.integrator);
  for (const auto& [option, has_use, others] :
       {Use{"--connections", connects, "makes no connections"}, Use{"--expected-iterations", connects, "has no pilot"},
        Use{"--radius", merges, "merges nothing"}, Use{"--alpha", merges, "merges nothing"},
        Use{"--light-paths", traces_light, "traces no light"}, Use{"--emission", traces_light, "traces no light"},
        Use{"--lights", makes_next_events, "samples no lights"}})
    if (is_given(option) && !has_use(options.integrator))
      throw InputError(std::string(option) + " needs " + names_of_those(has_use) + ": " + integrator + " " + others);
  if (!is_given("--scheme")) return;
  if (options.integrator != IntegratorChoice::gmis)
    throw InputError("--scheme needs --integrator gmis: " + integrator + " does not split");
  if (options.split == SplitChoice::none || options.split == SplitChoice::local)
    throw InputError("--scheme needs --split budgeted or paper: " + std::string(name_of(options.split)) +
                     " splits no subpaths");
}

/// The options as text, before they are checked.
struct RawOptions {
  std::string integrator = "auto", split = "local", connections = "auto", scheme = "N3", size, crop, seed, iterations;
  std::string expected_iterations;
  std::string replay, aov, isa, radius, sampler = "sobol", lights, emission;
  std::string tone = "clamp", completion, exposure = "auto", max_memory;
  double seconds = 0, relative_error = 0;
  bool manual = false;
};

void declare(CLI::App& app, Options& options, RawOptions& raw) {
  app.add_option("scene", options.scene, "A .pbrt, .gltf or .glb file, or the name of a built-in scene");
  app.add_flag("--list-scenes", options.list_scenes, "Print the built-in scenes, a line each");
  app.add_option("--integrator", raw.integrator,
                 "auto (what the scene calls for and what pays in it; the default), pt, lt, bpt, ppm, bpm, vcm or gmis")
      ->type_name("auto|pt|lt|bpt|ppm|bpm|vcm|gmis");
  app.add_option(
         "--split", raw.split,
         "Beyond vcm: local (counts that depend on the surface; the default), budgeted or paper (split subpaths), none "
         "(vcm)")
      ->type_name("local|budgeted|paper|none");
  app.add_option("--connections", raw.connections,
                 "Light vertices drawn per camera vertex: a number, auto (measured) or paired (all of one tree)")
      ->type_name("auto|paired|NUMBER");
  app.add_option("--scheme", raw.scheme,
                 "How the children of a split vertex are drawn: R1 R2 R3 N1 N2 N3 (the default)")
      ->type_name("R1|R2|R3|N1|N2|N3");
  app.add_option("--size", raw.size, "WIDTHxHEIGHT in pixels (the film's)")->type_name("WIDTHxHEIGHT");
  app.add_option("--max-depth", options.max_depth, "Most segments of a path, 1 to 256 (16); 2 is direct light")
      ->type_name("NUMBER");
  app.add_option(
         "--radius", raw.radius,
         "Merging radius of the first iteration in pixel widths, or with the suffix u in scene units (0.4 pixel "
         "widths; with local counts 3.2)")
      ->type_name("NUMBER");
  app.add_option("--alpha", options.alpha, "The radius shrinks as i^((alpha-1)/2) (2/3)")->type_name("NUMBER");
  app.add_option("--light-paths", options.light_paths, "Light trees per pixel (1; auto and gmis choose)")
      ->type_name("NUMBER");
  app.add_option("--seed", raw.seed, "Same seed, same picture, for any number of threads (0)")->type_name("NUMBER");
  app.add_option(
         "--sampler", raw.sampler,
         "How numbers are drawn: sobol (the default), 8 replications of low-discrepancy iterations, or independent")
      ->type_name("sobol|independent");
  app.add_option(
         "--lights", raw.lights,
         "How next events choose a light: power, receiver (power, distance and orientation seen from the shading "
         "point; pays with many lights) or learned (receiver where it pays; auto's default)")
      ->type_name("power|receiver|learned");
  app.add_option(
         "--emission", raw.emission,
         "Where light subpaths start: power (in proportion to emitted power) or learned (where their light is needed; "
         "auto's default)")
      ->type_name("power|learned");
  app.add_option("--threads", options.threads, "Threads (all cores); no more than there are processors are used")
      ->type_name("NUMBER");
  app.add_option("--iterations", raw.iterations,
                 "Stop after this number of iterations (64); 17..32/64: those of a run of 64, to be joined")
      ->type_name("NUMBER");
  app.add_option("--expected-iterations", raw.expected_iterations,
                 "Length of the run that a pilot chooses for (that of --iterations, or about that of --time; else 64)")
      ->type_name("NUMBER");
  app.add_option("--time", raw.seconds, "Stop after this number of seconds")->type_name("SECONDS");
  app.add_option("--error", raw.relative_error, "Stop when the estimated relative error has fallen to this value")
      ->type_name("NUMBER");
  app.add_option("--isa", raw.isa, "Fail unless the program is compiled for this instruction set: x86-64 or x86-64-v3")
      ->type_name("x86-64|x86-64-v3");
  app.add_option("--crop", raw.crop, "X0,Y0,X1,Y1: render these pixels only")->type_name("X0,Y0,X1,Y1");
  app.add_option("--effects", options.effects,
                 "Render only some effects: a list of no-NAME or NAME-only, of emission, direct, caustics, indirect, "
                 "mirrored, specular, glossy or a path class such as LS+DE")
      ->type_name("LIST");
  app.add_option(
         "--max-rejected", options.max_rejected,
         "Fail when more than this share of the contributions is not finite, negative or of density zero (1e-4)")
      ->type_name("NUMBER");
  app.add_flag("--list-rejected", options.list_rejected, "Print the first paths with rejected samples");
  app.add_option("--replay", raw.replay,
                 "Render nothing, print all about one path: ITERATION:PIXEL, ITERATION:X,Y or ITERATION:light:TREE")
      ->type_name("PATH");
  app.add_option("--techniques", options.techniques_folder, "Write an image per technique into this folder")
      ->type_name("FOLDER");
  app.add_option(
         "--aov", raw.aov,
         "classes: an image per path class in the folder NAME_classes beside the output; layers: albedo, normal, depth "
         "and variance as layers of each .exr, with classes also the path classes; techniques and lights: an image "
         "per technique and per light as layers; or several, with commas")
      ->type_name("classes|layers|techniques|lights");
  app.add_option("--exposure", raw.exposure,
                 "Make .png files 2^EV times as bright; auto (the default): so that their log-average is 0.25")
      ->type_name("auto|EV");
  app.add_option("--tone", raw.tone,
                 "How .png files are brought to values from 0 to 1: clamp (cut; the default), reinhard (x / (1 + "
                 "luminance)) or filmic (a fit of the ACES curve); the sRGB curve follows")
      ->type_name("clamp|reinhard|filmic");
  app.add_flag("--halves", options.halves, "Write two independent halves beside each output");
  app.add_flag("--denoise", options.denoise,
               "Write NAME_denoised beside each output, smoothed by Open Image Denoise where the program has it");
  app.add_option("--out", options.outputs, "Image file, .exr, .pfm or .png; may be repeated")
      ->type_name("FILE")
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->expected(1)
      ->allow_extra_args(false);
  app.add_option("--stats", options.statistics_file, "Write what was done and how long it took, as JSON")
      ->type_name("FILE");
  app.add_option("--log", options.log_file, "Write the error over time as CSV, updated during the run")
      ->type_name("FILE");
  app.add_option("--checkpoint", options.checkpoint_file,
                 "Keep the state of the run in this file, so that --resume can go on from it")
      ->type_name("FILE");
  app.add_option("--resume", options.resume_files,
                 "Go on from this checkpoint of a run with the same scene and options; given several times, for runs "
                 "with other seeds: join them into one picture and render nothing")
      ->type_name("FILE")
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->expected(1)
      ->allow_extra_args(false);
  app.add_option("--write-every", options.write_every,
                 "Seconds between updates of picture and checkpoint on disk during the run (30)")
      ->type_name("SECONDS");
  app.add_option("--tev", options.tev_address,
                 "Show the picture in the viewer tev as it grows; a viewer that is not there is a warning")
      ->type_name("HOST:PORT");
  app.add_option("--reference", options.reference_file, "Compare with this image (.exr or .pfm)")->type_name("FILE");
  app.add_flag("--check", options.check, "List everything unsupported in the scene, and render nothing");
  app.add_option("--sky", options.load.sky,
                 "Replace the sky: studio (what a glTF file without lights has), white, none, or an .exr or .pfm image")
      ->type_name("studio|white|none|FILE");
  app.add_option("--at", options.load.seconds, "Show the first animation of a glTF file at this time")
      ->type_name("SECONDS");
  app.add_option(
         "--max-memory", raw.max_memory,
         "Most memory that reading the scene may take, in bytes, or with the suffix M or G (3/4 of the machine's)")
      ->type_name("BYTES");
  app.add_flag("--lenient", options.lenient, "Render a scene with unsupported features; warn of each");
  app.add_flag("--explain", options.explain, "Say what will be done, and why");
  app.add_flag("--quiet", options.quiet,
               "Print nothing but errors, and what --explain, --list-rejected and --replay print");
  app.add_flag("--man", raw.manual, "Print the manual page, as man -l - reads it");
  app.add_option("--completion", raw.completion, "Print a script that completes this command line in a shell")
      ->type_name("bash|zsh|fish");
}

/// Nothing for `auto`.
std::optional<double> exposure_of(const std::string& text) {
  if (text == "auto") return {};
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !(std::abs(value) <= 100))
    throw InputError("--exposure must be auto or a number from -100 to 100");
  return value;
}

std::uintmax_t bytes_of(const std::string& text) {
  std::uintmax_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string_view unit(end, text.data() + text.size());
  const unsigned shift = unit == "G" ? 30 : unit == "M" ? 20 : 0;
  if (error != std::errc{} || (shift == 0 && !unit.empty()) || value == 0 || value > std::uintmax_t{1} << (50 - shift))
    throw InputError("--max-memory " + in_quotes(text) +
                     " must be a whole number of bytes from 1 to 2^50, or have the suffix M or G");
  return value << shift;
}

ToneCurve tone_of(const std::string& name) {
  if (name == "clamp") return ToneCurve::clamp;
  if (name == "reinhard") return ToneCurve::reinhard;
  if (name == "filmic") return ToneCurve::filmic;
  throw InputError("--tone " + in_quotes(name) + " is not known: use clamp, reinhard or filmic");
}

/// Name, description and options of the program, as the parser has them.
ProgramSummary summary_of(const CLI::App& app) {
  ProgramSummary summary{app.get_name(), GMIS_VERSION, app.get_description(), "[SCENE]", "--list-scenes", {}};
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_lnames().empty()) continue;  // the scene
    const std::string value = option->get_type_size_max() == 0 ? "" : option->get_type_name();
    summary.options.push_back({"--" + option->get_lnames().front(), value, option->get_description()});
  }
  return summary;
}

}  // namespace

std::array<int, 2> size_of(const std::string& text) {
  const auto size = integers_of<2>(text, 'x');
  constexpr int largest = 32768;
  if (!size || (*size)[0] < 1 || (*size)[1] < 1 || (*size)[0] > largest || (*size)[1] > largest)
    throw InputError("--size " + in_quotes(text) + " must be WIDTHxHEIGHT, each from 1 to 32768");
  return *size;
}

std::uint64_t seed_of(const std::string& text) {
  return whole_number_of<std::uint64_t>("--seed", text);
}

void require_above_zero(const char* option, double value) {
  if (!(value > 0) || !std::isfinite(value)) throw InputError(std::string(option) + " must be above 0 and finite");
}

void require_in_range(const Options& options) {
  if (options.max_depth < 1 || options.max_depth > 256) throw InputError("--max-depth must be from 1 to 256");
  if (options.light_paths) require_above_zero("--light-paths", *options.light_paths);
  if (options.light_paths > 1000.0) throw InputError("--light-paths must be at most 1000");
  if (!(options.alpha > 0 && options.alpha <= 1)) throw InputError("--alpha must be above 0 and at most 1");
}

PathChoice path_choice_of(const std::string& text) {
  PathChoice choice;
  const char* position = text.data();
  const char* const end = position + text.size();
  bool is_understood = true;
  const auto number = [&](std::uint32_t& value) {
    const auto [next, error] = std::from_chars(position, end, value);
    is_understood = is_understood && error == std::errc{};
    position = next;
  };
  const auto skip = [&](std::string_view part) {
    if (!std::string_view(position, static_cast<std::size_t>(end - position)).starts_with(part)) return false;
    position += part.size();
    return true;
  };
  number(choice.iteration);
  is_understood = skip(":") && is_understood && choice.iteration > 0;
  choice.is_light = skip("light:");
  number(choice.number);
  if (!choice.is_light && skip(",")) {
    choice.pixel = {choice.number, 0};
    number((*choice.pixel)[1]);
  }
  if (!is_understood || position != end)
    throw InputError("--replay " + in_quotes(text) +
                     " must be ITERATION:PIXEL, ITERATION:X,Y or ITERATION:light:TREE, with iterations from 1 on");
  return choice;
}

std::optional<Options> parse_command_line(int argc, char** argv) {
  Options options;
  RawOptions raw;
  CLI::App app("Renders a scene with generalized multiple importance sampling.", "gmis-render");
  app.set_version_flag("--version", GMIS_VERSION);
  declare(app, options, raw);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    app.exit(success);
    return {};
  } catch (const CLI::ParseError& error) {
    throw InputError(error.what() + std::string("; see --help"));
  }
  if (raw.manual || !raw.completion.empty()) {
    const ProgramSummary summary = summary_of(app);
    std::fputs((raw.manual ? manual_page(summary) : completion_script(summary, raw.completion)).c_str(), stdout);
    return {};
  }
  for (const CLI::Option* option : app.get_options())
    for (const std::string& value : option->results())
      if (value.empty()) throw InputError(option->get_name() + " is empty: give it a value, or leave it out");
  const auto given = [&](const char* option) { return app.count(option) > 0; };

  // --split and --scheme imply --integrator gmis.
  if ((given("--split") || given("--scheme")) && !given("--integrator"))
    raw.integrator = name_of(IntegratorChoice::gmis);
  options.integrator = integrator_of(raw.integrator);
  options.split = split_of(raw.split);
  if (options.integrator != IntegratorChoice::gmis) {
    if (given("--split") && options.split != SplitChoice::none)
      throw InputError("--split needs --integrator gmis: " + raw.integrator + " does not split");
    options.split = SplitChoice::none;
  }
  if (given("--effects")) {
    const SwitchedEffects effects = switched_effects(options.effects);
    if (!effects.unknown.empty())
      throw InputError("--effects " + in_quotes(effects.unknown) +
                       " is not known: use no-NAME or NAME-only with emission, direct, caustics, indirect, mirrored, "
                       "specular, glossy or a path class such as LS+DE");
    if (effects.classes.is_empty())
      throw InputError("--effects " + in_quotes(options.effects) + " leaves nothing to render: leave out fewer");
    options.path_classes = effects.classes;
  }
  if (given("--aov")) {
    std::stringstream names(raw.aov);
    for (std::string name; std::getline(names, name, ',');) {
      bool* const option = name == "classes"      ? &options.class_images
                           : name == "layers"     ? &options.layers
                           : name == "techniques" ? &options.technique_layers
                           : name == "lights"     ? &options.light_layers
                                                  : nullptr;
      if (option == nullptr)
        throw InputError("--aov " + in_quotes(name) + " is not known: use classes, layers, techniques or lights");
      *option = true;
    }
  }
  options.connections = connections_of(raw.connections);
  options.connects_paired_tree = raw.connections == "paired";
  if (given("--scheme") && !given("--split") && options.split == SplitChoice::local)
    options.split = SplitChoice::budgeted;  // --scheme implies split subpaths
  refuse_idle_options(options, given);
  options.scheme = scheme_of(raw.scheme);
  options.sampler = sampler_of(raw.sampler);
  options.lights = raw.lights.empty() ? default_lights(options.integrator) : lights_of(raw.lights);
  options.emission = raw.emission.empty() ? default_emission(options.integrator) : emission_of(raw.emission);
  options.tone = tone_of(raw.tone);
  if (given("--size")) options.size = size_of(raw.size);
  if (given("--crop")) options.crop = crop_of(raw.crop);
  require_in_range(options);
  if (given("--radius")) options.radius = radius_of(raw.radius);
  if (given("--threads") && (options.threads < 1 || options.threads > 4096))
    throw InputError("--threads must be from 1 to 4096");
  if (given("--isa") && raw.isa != instruction_set)
    throw InputError("--isa " + in_quotes(raw.isa) + ": this program is compiled for " + std::string(instruction_set) +
                     "; ./run --isa LEVEL path gmis-render builds one for x86-64 or x86-64-v3 and prints where it is");
  if (given("--seed")) options.seed = seed_of(raw.seed);
  if (given("--iterations")) {
    options.part = run_part_of(raw.iterations);
    options.iterations =
        options.part ? options.part->of : whole_number_of<std::uint32_t>("--iterations", raw.iterations, 1);
  }
  if (given("--expected-iterations"))
    options.expected_iterations = whole_number_of<std::uint32_t>("--expected-iterations", raw.expected_iterations, 1);
  if (given("--time")) {
    require_above_zero("--time", raw.seconds);
    options.seconds = raw.seconds;
  }
  if (given("--error")) {
    require_above_zero("--error", raw.relative_error);
    options.relative_error = raw.relative_error;
  }
  if (!(options.max_rejected >= 0 && (options.max_rejected <= 1 || std::isinf(options.max_rejected))))
    throw InputError("--max-rejected must be a share from 0 to 1, or inf");
  if (!(options.write_every >= 0)) throw InputError("--write-every must be a number of seconds from 0 on");
  options.exposure = exposure_of(raw.exposure);
  if (!raw.max_memory.empty()) options.load.max_memory = bytes_of(raw.max_memory);
  if (options.load.seconds && !std::isfinite(*options.load.seconds)) throw InputError("--at must be a number");
  for (int i = 0; i < argc; ++i) options.command_line += (i > 0 ? " " : "") + std::string(argv[i]);
  if (given("--replay")) options.replay = path_choice_of(raw.replay);
  if (options.resume_files.size() > 1 && !options.checkpoint_file.empty())
    throw InputError("--checkpoint goes with one --resume: several are joined, and nothing is rendered");
  if (options.part && (options.checkpoint_file.empty() || options.seconds || options.relative_error))
    throw InputError(
        "--iterations FIRST..LAST/OF needs --checkpoint, which --resume joins, and excludes --time and --error");
  if (!options.iterations && !options.seconds && !options.relative_error) options.iterations = 64;
  if (options.replay && options.iterations && options.replay->iteration > *options.iterations)
    throw InputError("--replay " + in_quotes(raw.replay) + ": the run has " + std::to_string(*options.iterations) +
                     (*options.iterations == 1 ? " iteration" : " iterations") + ": give the --iterations of the run");
  if (!options.list_scenes && options.scene.empty())
    throw InputError("name a scene: a .pbrt, .gltf or .glb file, or one that --list-scenes prints; see --help");
  return options;
}

}  // namespace gmis::tools
