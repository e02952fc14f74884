// SPDX-License-Identifier: Apache-2.0
#pragma once
// What `orthodrive-train --help` prints; the manual page of `orthodrive train` shows it, too.

namespace orthodrive::app {

inline constexpr const char* train_packed_usage =
    "Trains a segmentation network on a data set written by `orthodrive train --pack`.\n"
    "Usage: orthodrive-train PACKED -o DIR [options]\n\n"
    "  -o, --output DIR   folder for model.safetensors, checkpoint.safetensors, log.csv\n"
    "  --weights FILE     safetensors to start from, asked in the order given: those the experiment names\n"
    "  --resume           go on from the checkpoint in the folder\n"
    "  --crf              on top of the network trained in the folder: search a CRF, then learn both end to end\n"
    "  --cuda             train on the GPU\n"
    "  --threads N        worker threads, 0 = all cores [0]; the outcome repeats for the same number\n"
    "  -q, --quiet        no messages and no progress bar on stderr\n"
    "  -h, --help         this text\n\n"
    "Reads the pack into memory (4 bytes a pixel in it, 11 in memory). What it writes is what `orthodrive train` "
    "writes.\n"
    "Examples:\n"
    "  orthodrive-train data.safetensors -o out/train --weights imagenet.safetensors --cuda\n"
    "  orthodrive-train data.safetensors -o out/train --cuda --resume\n"
    "Exit codes: 0 done, 1 data or processing, 2 usage.\n";

}  // namespace orthodrive::app
