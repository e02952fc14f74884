// SPDX-License-Identifier: Apache-2.0
// orthodrive-train: `orthodrive train` on a data set written by `orthodrive train --pack`, built with nothing but
// libtorch (tools/trainer). Exit codes: 0 done, 1 data or processing, 2 usage.

#include <fmt/format.h>
#include <malloc.h>

#include <charconv>
#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "orthodrive/core/error.hpp"
#include "orthodrive/io/models/safetensors_stream.hpp"
#include "orthodrive/lab/training/packed_scenes.hpp"
#include "orthodrive/lab/training/training_run.hpp"
#include "terminal_monitor.hpp"
#include "train_packed_usage.hpp"

namespace orthodrive::app {
namespace {
namespace fs = std::filesystem;

struct Arguments {
  fs::path pack, out;
  std::vector<fs::path> weights;
  int threads = 0;
  bool resume = false, crf = false, cuda = false, quiet = false, help = false;
};

int thread_count(std::string_view text) {
  int count = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  if (error != std::errc() || end != text.data() + text.size() || count < 0 || count > 1024)
    throw OptionError(fmt::format("--threads {}: must be a number from 0 to 1024", text));
  return count;
}

Arguments parse_arguments(const std::vector<std::string>& words) {
  Arguments arguments;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    const auto value = [&]() -> const std::string& {
      if (i + 1 == words.size()) throw OptionError(word + ": its value is missing");
      return words[++i];
    };
    if (word == "-o" || word == "--output")
      arguments.out = value();
    else if (word == "--weights")
      arguments.weights.emplace_back(value());
    else if (word == "--threads")
      arguments.threads = thread_count(value());
    else if (word == "--resume")
      arguments.resume = true;
    else if (word == "--crf")
      arguments.crf = true;
    else if (word == "--cuda")
      arguments.cuda = true;
    else if (word == "-q" || word == "--quiet")
      arguments.quiet = true;
    else if (word == "-h" || word == "--help")
      arguments.help = true;
    else if (word.starts_with('-'))
      throw OptionError(word + ": no such option, see --help");
    else if (!arguments.pack.empty())
      throw OptionError(word + ": there is a data set already, see --help");
    else
      arguments.pack = word;
  }
  if (arguments.help) return arguments;
  if (arguments.crf && !arguments.weights.empty())
    throw OptionError("--weights changes nothing with --crf: it goes on from the model in the folder");
  if (arguments.pack.empty()) throw OptionError("the packed data set is missing, see --help");
  if (arguments.out.empty()) throw OptionError("-o is missing: the folder to train into");
  return arguments;
}

std::vector<WeightsSource> read_weights(const std::vector<fs::path>& files, const Experiment& experiment) {
  if (files.empty() && !experiment.weights.empty()) {
    std::string names;
    for (const fs::path& file : experiment.weights) names += fmt::format(" --weights {}", file.filename().string());
    throw OptionError(fmt::format("the experiment starts from weights that are not in the pack: give{}", names));
  }
  std::vector<WeightsSource> sources;
  for (const fs::path& file : files) {
    if (file.extension() == ".caffemodel") {
      throw OptionError(
          fmt::format("{}: give the safetensors file that `orthodrive train --pack` made of it", file.string()));
    }
    sources.push_back({file.filename().string(), read_safetensors(file)});
  }
  return sources;
}

void train_packed(const Arguments& arguments, Monitor& monitor) {
  prepare_training_folder(arguments.out, arguments.resume, arguments.crf);
  PackedScenes packed = read_packed_scenes(arguments.pack);
  const auto text_of = [&](const char* key) {
    const auto found = packed.metadata.find(key);
    if (found == packed.metadata.end())
      throw InputError(arguments.pack.string(), fmt::format("has no '{}': pack it again", key));
    return found->second;
  };
  // Messages name the texts as if the pack were a folder.
  const std::string experiment_text = text_of("experiment");
  Experiment experiment = parse_experiment(experiment_text, arguments.pack / "experiment.toml");
  experiment.train.threads = arguments.threads;
  experiment.train.cuda = arguments.cuda;
  const NetworkSpec network = parse_network_spec(text_of("network"), arguments.pack / "network.toml");
  const ClassTable classes = parse_model_metadata(packed.metadata, arguments.pack.string()).classes;
  run_training({.out = arguments.out,
                .experiment_text = experiment_text,
                .experiment = experiment,
                .network = network,
                .classes = classes,
                .scenes = std::move(packed.scenes),
                .validation = std::move(packed.validation),
                .read_weights = [&] { return read_weights(arguments.weights, experiment); },
                .resume = arguments.resume,
                .crf = arguments.crf},
               &monitor);
}

}  // namespace
}  // namespace orthodrive::app

int main(int argc, char** argv) {
  // Large arrays come and go: give them back to the system instead of keeping them in the arena.
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
  using namespace orthodrive::app;
  TerminalMonitor monitor;
  int code = 0;
  std::string message;
  try {
    const Arguments arguments = parse_arguments({argv + 1, argv + argc});
    monitor.quiet = arguments.quiet;
    if (arguments.help)
      fmt::print("{}", train_packed_usage);
    else
      train_packed(arguments, monitor);
  } catch (const orthodrive::OptionError& error) {
    code = 2, message = error.what();
  } catch (const std::exception& error) {
    code = 1, message = error.what();
  }
  monitor.clear_bar();
  if (code != 0) fmt::print(stderr, "orthodrive-train: {}\n", message);
  return code;
}
