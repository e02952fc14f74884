// SPDX-License-Identifier: Apache-2.0
// Included before everything else when clang-tidy reads what g++ compiles. Nothing here is ever run.
#pragma once
#include <string>

// In C++20 std::vector is constexpr, and clang then wants the element's type to be complete earlier than g++ does:
// libtorch's headers (c10::IValue) do not compile. So <vector> is read as C++17 has it. One function of it has been
// declared before, as constexpr, hence the other name.
#undef _GLIBCXX20_CONSTEXPR
#define _GLIBCXX20_CONSTEXPR
#define __fill_a1 __fill_bits
#include <vector>
#undef __fill_a1
#undef _GLIBCXX20_CONSTEXPR
#define _GLIBCXX20_CONSTEXPR constexpr

// g++'s shuffle of vectors; only its type matters here.
#define __builtin_shuffle(vector, ...) (vector)
