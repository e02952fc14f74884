// SPDX-License-Identifier: Apache-2.0
#include "fmu/instance.hpp"

const fmu::ModelKind& fmu::this_model() { return car_model(); }
