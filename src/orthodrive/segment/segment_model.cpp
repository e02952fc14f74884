#include "orthodrive/segment/segment_model.hpp"

#include <fmt/format.h>

#include "orthodrive/core/error.hpp"
#include "orthodrive/segment/fcn.hpp"
#include "orthodrive/segment/model_metadata.hpp"

namespace orthodrive {

SegmentModel load_model(std::string_view bytes, const std::string& source) {
  const TensorFile file = parse_safetensors(bytes, source);
  const ModelMetadata metadata = parse_model_metadata(file.metadata, source);
  if (metadata.architecture != FcnSpec::architecture) {
    throw InputError(source, fmt::format("architecture is '{}', this program knows '{}'", metadata.architecture,
                                         FcnSpec::architecture));
  }
  const auto head = file.tensors.find("head/kernel");
  const std::int64_t scores = head == file.tensors.end() || head->second.shape.empty() ? 0 : head->second.shape.back();
  if (scores != static_cast<std::int64_t>(metadata.classes.classes.size())) {
    throw InputError(
        source,
        fmt::format(
            "class table '{}' has {} classes but the weights score {}: use the table the model was trained with",
            metadata.classes.name, metadata.classes.classes.size(), scores));
  }
  FcnSpec spec = make_fcn_spec(static_cast<int>(scores));
  const FcnParams params = params_from_file(spec, file, source);
  return {metadata.architecture, metadata.classes, metadata.gsd_m,
          std::make_shared<InferenceNetwork>(std::move(spec), params)};
}

}  // namespace orthodrive
