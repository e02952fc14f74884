// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/core/escape_xml.hpp"

#include <gtest/gtest.h>

namespace orthodrive {
namespace {

TEST(EscapeXml, what_would_end_text_or_an_attribute) {
  EXPECT_EQ(escape_xml("a<b> & \"c\""), "a&lt;b&gt; &amp; &quot;c&quot;");
  EXPECT_EQ(escape_xml("&lt;"), "&amp;lt;");
  EXPECT_EQ(escape_xml("Straße 'x'"), "Straße 'x'");
  EXPECT_EQ(escape_xml(""), "");
}

}  // namespace
}  // namespace orthodrive
