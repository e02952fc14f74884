// SPDX-License-Identifier: Apache-2.0
#pragma once
// Step 5 of fuse_drive_logs: what is known of the corrections without any measurement. They are small and smooth, and
// roads agree where they meet.

#include "orthodrive/elevate/logs/fusion_problem.hpp"

namespace orthodrive::elevate {

/// Each correction is a Gaussian process of Matern 5/2 covariance with the standard deviation of the given profile:
/// exactly that of (d/ds + k)^3 u = white noise of power 16/3 k^5 (Hartikainen and Sarkka, Kalman filtering and
/// smoothing solutions to temporal Gaussian process regression models, 2010), started in its steady state. Its
/// curvature has a standard deviation of k^2 sigma: a correction is no rougher than a road.
void add_correction_prior(const FusionProblem& problem, WeightedRows& rows);

/// Equal heights where roads meet. A road without measurements follows the plane of the driven one, so that the angle
/// between them stays; closed chains join C2.
void add_chain_ties(const FusionProblem& problem, WeightedRows& rows);

}  // namespace orthodrive::elevate
