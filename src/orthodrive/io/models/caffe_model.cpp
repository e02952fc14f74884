// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/models/caffe_model.hpp"

#include <fmt/format.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/stubs/logging.h>
#include <google/protobuf/wire_format_lite.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "caffe_net.pb.h"
#include "orthodrive/core/error.hpp"
#include "orthodrive/core/printable.hpp"

namespace orthodrive {
namespace {

using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedInputStream;

constexpr const char* remedy = "fetch it again, or take a binary .caffemodel as Caffe writes it";

/// A layer of either layout.
struct CaffeLayer {
  std::string name, type;
  std::int64_t group = 1;
  google::protobuf::RepeatedPtrField<caffe::BlobProto> blobs;
};

/// A blob's floats and axes.
struct Blob {
  std::vector<std::int64_t> shape;
  std::vector<float> values;
};

std::string type_of_v1(int type) {
  switch (type) {  // V1LayerParameter.LayerType; newer types exist in new files only
    case 4:
      return "Convolution";
    case 14:
      return "InnerProduct";
    case 39:
      return "Deconvolution";
    default:
      return fmt::format("V1 type {}", type);
  }
}

Blob take_blob(caffe::BlobProto& proto) {
  Blob blob;
  if (proto.has_shape()) {
    blob.shape.assign(proto.shape().dim().begin(), proto.shape().dim().end());
  } else {
    blob.shape = {proto.num(), proto.channels(), proto.height(), proto.width()};
  }
  std::uint64_t count = 1;
  for (const std::int64_t n : blob.shape) {
    if (n < 0 || n > std::numeric_limits<std::int32_t>::max()) throw Error("a blob has an impossible shape");
    count *= static_cast<std::uint64_t>(n);
    if (count > static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max())) {
      throw Error("a blob has an impossible shape");
    }
  }
  const auto stored = static_cast<std::uint64_t>(proto.data_size() > 0 ? proto.data_size() : proto.double_data_size());
  if (stored != count) throw Error(fmt::format("a blob of {} numbers holds {}", count, stored));
  if (proto.data_size() > 0) {
    blob.values.assign(proto.data().begin(), proto.data().end());
  } else {
    blob.values.assign(proto.double_data().begin(), proto.double_data().end());
  }
  proto.Clear();
  google::protobuf::RepeatedField<float>().Swap(proto.mutable_data());  // Clear() keeps the memory
  return blob;
}

/// Drops leading axes of length 1, of which old files have four always.
void squeeze_to(std::size_t axes, Blob& blob) {
  while (blob.shape.size() > axes && blob.shape.front() == 1) blob.shape.erase(blob.shape.begin());
  if (blob.shape.size() != axes) {
    throw Error(fmt::format("a blob has {} axes where {} are expected", blob.shape.size(), axes));
  }
}

/// A x B x H x W -> H x W x B x A: kernels of convolutions and, with the channels' roles exchanged, of deconvolutions.
Blob reverse_channels_last(const Blob& from) {
  const std::int64_t a_size = from.shape[0], b_size = from.shape[1], pixels = from.shape[2] * from.shape[3];
  Blob to{{from.shape[2], from.shape[3], b_size, a_size}, std::vector<float>(from.values.size())};
  std::size_t i = 0;
  for (std::int64_t a = 0; a < a_size; ++a) {
    for (std::int64_t b = 0; b < b_size; ++b) {
      for (std::int64_t p = 0; p < pixels; ++p) {
        to.values[static_cast<std::size_t>((p * b_size + b) * a_size + a)] = from.values[i++];
      }
    }
  }
  return to;
}

void put(TensorFile& file, const std::string& name, Blob blob) {
  const bool is_new = file.tensors.emplace(name, NamedTensor{std::move(blob.shape), std::move(blob.values)}).second;
  if (!is_new) throw Error(fmt::format("'{}' is there twice", name));
}

/// Caffe accumulates mean and variance together with the sum of their weights (batch_norm_layer.cpp).
void divide_by_factor(Blob& blob, float factor) {
  for (float& v : blob.values) v = factor == 0.0F ? 0.0F : v / factor;
}

void add_batch_norm(TensorFile& file, const std::string& name, std::vector<Blob> blobs) {
  if (blobs.size() < 3 || blobs[2].values.size() != 1) throw Error("BatchNorm needs mean, variance and their factor");
  for (std::size_t i = 0; i < 2; ++i) {
    squeeze_to(1, blobs[i]);
    divide_by_factor(blobs[i], blobs[2].values[0]);
    put(file, name + (i == 0 ? "/moving_mean" : "/moving_variance"), std::move(blobs[i]));
  }
}

void add_scale(TensorFile& file, const std::string& name, std::vector<Blob> blobs) {
  for (std::size_t i = 0; i < blobs.size(); ++i) {
    if (i > 1) throw Error("Scale has more than two blobs");
    put(file, name + (i == 0 ? "/gamma" : "/beta"), std::move(blobs[i]));
  }
}

void add_convolution(TensorFile& file, const CaffeLayer& layer, Blob kernel) {
  squeeze_to(4, kernel);
  const bool transposed = layer.type == "Deconvolution";
  if (layer.group < 1 || kernel.shape[0] % layer.group != 0) {
    throw Error(fmt::format("{} channels cannot be divided into {} groups", kernel.shape[0], layer.group));
  }
  const bool depthwise = !transposed && layer.group > 1 && layer.group == kernel.shape[0] && kernel.shape[1] == 1;
  Blob ours = reverse_channels_last(kernel);
  if (depthwise) std::swap(ours.shape[2], ours.shape[3]);
  put(file,
      layer.name + (transposed  ? "/transposed_kernel"
                    : depthwise ? "/depthwise_kernel"
                                : "/kernel"),
      std::move(ours));
}

void add_layer(TensorFile& file, CaffeLayer layer) {
  if (layer.blobs.empty()) return;
  std::vector<Blob> blobs;
  blobs.reserve(layer.blobs.size());
  for (caffe::BlobProto& proto : layer.blobs) blobs.push_back(take_blob(proto));
  const bool convolution = layer.type == "Convolution" || layer.type == "Deconvolution";
  if (convolution || layer.type == "InnerProduct") {
    if (convolution) {
      add_convolution(file, layer, std::move(blobs[0]));
    } else {
      squeeze_to(2, blobs[0]);
      put(file, layer.name + "/inner_product", std::move(blobs[0]));
    }
    if (blobs.size() > 2) throw Error(fmt::format("{} has more than two blobs", layer.type));
    if (blobs.size() == 2) {
      squeeze_to(1, blobs[1]);
      put(file, layer.name + "/bias", std::move(blobs[1]));
    }
  } else if (layer.type == "BatchNorm") {
    add_batch_norm(file, layer.name, std::move(blobs));
  } else if (layer.type == "Scale") {
    add_scale(file, layer.name, std::move(blobs));
  } else {
    for (std::size_t i = 0; i < blobs.size(); ++i)
      put(file, fmt::format("{}/blob{}", layer.name, i), std::move(blobs[i]));
  }
  file.metadata[layer.name + "/type"] = layer.type;
  if (layer.group != 1) file.metadata[layer.name + "/group"] = fmt::format("{}", layer.group);
}

/// The message of that length which comes next.
template <typename Message>
bool read_message(CodedInputStream& in, Message& message) {
  int length = 0;
  if (!in.ReadVarintSizeAsInt(&length)) return false;
  const auto limit = in.PushLimit(length);
  if (!message.MergePartialFromCodedStream(&in) || !in.ConsumedEntireMessage() || in.BytesUntilLimit() != 0)
    return false;
  in.PopLimit(limit);
  return true;
}

/// A layer at a time, so that the net is not held twice. False where the bytes are no protobuf.
bool read_layers(CodedInputStream& in, TensorFile& file, std::string& place) {
  constexpr int wire_bytes = WireFormatLite::WIRETYPE_LENGTH_DELIMITED;
  while (const std::uint32_t tag = in.ReadTag()) {
    const int field = WireFormatLite::GetTagFieldNumber(tag);
    if ((tag & 7U) == wire_bytes && field == caffe::NetParameter::kLayerFieldNumber) {
      caffe::LayerParameter proto;
      if (!read_message(in, proto)) return false;
      place = proto.name();
      CaffeLayer layer{proto.name(), proto.type(), proto.convolution_param().group(), {}};
      layer.blobs.Swap(proto.mutable_blobs());
      add_layer(file, std::move(layer));
    } else if ((tag & 7U) == wire_bytes && field == caffe::NetParameter::kLayersFieldNumber) {
      caffe::V1LayerParameter proto;
      if (!read_message(in, proto)) return false;
      if (proto.has_layer())
        throw Error("it is of Caffe before 2014 (V0): convert it with Caffe's upgrade_net_proto_binary");
      place = proto.name();
      CaffeLayer layer{proto.name(), type_of_v1(proto.type()), proto.convolution_param().group(), {}};
      layer.blobs.Swap(proto.mutable_blobs());
      add_layer(file, std::move(layer));
    } else if ((tag & 7U) == wire_bytes && field == caffe::NetParameter::kNameFieldNumber) {
      if (!WireFormatLite::ReadString(&in, &file.metadata["network"])) return false;
    } else if (!WireFormatLite::SkipField(&in, tag)) {
      return false;
    }
  }
  return in.ConsumedEntireMessage();
}

TensorFile read_net(google::protobuf::io::ZeroCopyInputStream& stream, const std::string& source) {
  google::protobuf::SetLogHandler(nullptr);  // it would tell standard error of every odd text
  CodedInputStream in(&stream);
  in.SetTotalBytesLimit(std::numeric_limits<int>::max());
  TensorFile file;
  std::string place;
  try {
    if (!read_layers(in, file, place)) throw Error("truncated, or no protobuf");
    if (file.tensors.empty()) throw Error("no layer has weights");
  } catch (const Error& error) {
    throw InputError(source, fmt::format("not a usable Caffe model ({}{}): {}",
                                         place.empty() ? "" : fmt::format("at or after layer '{}': ", printable(place)),
                                         printable(error.what()), remedy));
  }
  return file;
}

}  // namespace

TensorFile read_caffe_model(std::istream& stream, const std::string& source) {
  google::protobuf::io::IstreamInputStream input(&stream);
  TensorFile file = read_net(input, source);
  if (stream.bad()) throw InputError(source, "cannot be read to its end");
  return file;
}

TensorFile parse_caffe_model(std::string_view bytes, const std::string& source) {
  if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    throw InputError(source, "longer than 2^31 - 1 bytes, the limit of protobuf: no Caffe model can be");
  }
  google::protobuf::io::ArrayInputStream input(bytes.data(), static_cast<int>(bytes.size()));
  return read_net(input, source);
}

}  // namespace orthodrive
