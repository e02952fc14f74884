// SPDX-License-Identifier: Apache-2.0
// orthodrive train: a segmentation network from an experiment.

#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "commands/idle_options.hpp"
#include "commands/stage_output.hpp"
#include "lab_commands.hpp"
#include "load_lab.hpp"
#include "orthodrive/core/error.hpp"

namespace orthodrive::app {
namespace {
struct TrainCommand {
  TrainFiles files;
  std::filesystem::path pack;  ///< write the data set instead of training
  MeasureOptions measure;      ///< with a model: measure it instead of training one
  RunTrainOptions options;
  bool preview = false;
  IdleOptions idle;
};

void run(TrainCommand& command, const Context& context) {
  command.idle.refuse();
  StageContext stage = stage_context(context);
  if (!command.measure.model.empty()) {
    command.measure.crf = command.options.crf;
    fmt::print("{}\n", lab_runs().measure_on_held_out_data(command.files, command.measure, stage).dump(2));
    return;
  }
  if (!command.pack.empty()) return lab_runs().pack_training(command.files, command.pack, stage);
  if (command.files.folder.empty()) throw OptionError("-o is missing: the folder to train into");
  if (command.preview)
    lab_runs().preview_training(command.files, stage);
  else
    lab_runs().run_train(command.files, command.options, stage);
}

void add_options(CLI::App& cmd, TrainCommand& command) {
  CLI::Option* output = cmd.add_option("-o,--output", command.files.folder,
                                       "folder for model.safetensors, checkpoint.safetensors, log.csv");
  CLI::Option* resume = cmd.add_flag("--resume", command.options.resume, "go on from the checkpoint in the folder");
  CLI::Option* crf = cmd.add_flag(
      "--crf", command.options.crf,
      "on top of the network trained in the folder: search a CRF's widths and weights, then learn both end to end; "
      "with --measure: with the model's CRF");
  CLI::Option* cuda = cmd.add_flag("--cuda", command.options.cuda, "train on the GPU, where libtorch has one");
  CLI::Option* measure =
      cmd.add_option("--measure", command.measure.model,
                     "instead of training, print the scores of this model on the held-out data as JSON");
  command.idle.needs(cmd.add_option("--set", command.measure.sets, "of --measure: only these of the held-out data"),
                     {measure});
  CLI::Option* weights =
      cmd.add_option("--weights", command.files.weights,
                     "start from these (safetensors or .caffemodel, asked in this order), not from the experiment's");
  cmd.add_option("--leave-out", command.files.leave_out,
                 "data sets to leave out and measure as a whole, in place of the experiment's 'leave_out'");
  CLI::Option* pack = cmd.add_option(
      "--pack", command.pack,
      "instead of training, write the data set into this safetensors file, to train on a machine with nothing "
      "but libtorch (orthodrive-train, built by tools/trainer)");
  CLI::Option* preview = cmd.add_flag(
      "--preview", command.preview,
      "only write pictures of the labels and the shares of their classes into the folder, to look at before training");
  command.idle.excludes(output, {measure, pack});
  command.idle.excludes(preview, {measure, pack});
  command.idle.excludes(pack, {measure});
  for (CLI::Option* of_training : {resume, cuda}) command.idle.excludes(of_training, {measure, pack, preview});
  command.idle.excludes(crf, {pack, preview});
  command.idle.excludes(weights, {measure, preview, crf});
}
}  // namespace

void add_train(CLI::App& app, Context& context) {
  auto command = std::make_shared<TrainCommand>();
  CLI::App* cmd = app.add_subcommand("train", "Trains a segmentation network on photos, maps and synthetic sites.");
  cmd->add_option("experiment", command->files.experiment, "what to train on and how (TOML, see docs/train.md)")
      ->required();
  add_options(*cmd, *command);
  cmd->footer(
      "Reads the experiment and the data it names; writes into the output folder.\n"
      "The outcome repeats for the same number of threads. Needs about 4 GB; the shipped model took an hour on two "
      "cores.\n"
      "Examples:\n"
      "  orthodrive train models/default.toml -o out/train --preview\n"
      "  orthodrive train models/default.toml -o out/train --resume\n"
      "  orthodrive train models/default.toml --measure default");
  cmd->callback([command, &context] { run(*command, context); });
}

}  // namespace orthodrive::app
