// SPDX-License-Identifier: Apache-2.0
#include "orthodrive/io/models/safetensors_stream.hpp"

#include <fmt/format.h>

#include <ostream>
#include <utility>

#include "orthodrive/core/error.hpp"

namespace orthodrive {

SafetensorsWriter::SafetensorsWriter(std::ostream& out, const std::map<std::string, std::string>& metadata,
                                     std::vector<TensorSpec> tensors)
    : out_(out), tensors_(std::move(tensors)) {
  const std::string header = format_safetensors_header(metadata, tensors_);
  out_.write(header.data(), static_cast<std::streamsize>(header.size()));
}

void SafetensorsWriter::skip_complete() {
  while (tensor_ < tensors_.size() && written_bytes_ == byte_count(tensors_[tensor_])) ++tensor_, written_bytes_ = 0;
}

void SafetensorsWriter::write(const std::string& name, std::span<const std::byte> bytes) {
  if (bytes.empty()) return;
  skip_complete();
  if (tensor_ == tensors_.size() || tensors_[tensor_].name != name ||
      bytes.size() > byte_count(tensors_[tensor_]) - written_bytes_) {
    throw Error(fmt::format("{} bytes of tensor '{}' do not fit where {}", bytes.size(), name,
                            tensor_ == tensors_.size()
                                ? "all is written"
                                : fmt::format("{} of '{}' are due", byte_count(tensors_[tensor_]) - written_bytes_,
                                              tensors_[tensor_].name)));
  }
  out_.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!out_) throw Error(fmt::format("tensor '{}' cannot be written: is the disk full?", name));
  written_bytes_ += bytes.size();
}

void SafetensorsWriter::finish() {
  skip_complete();
  if (tensor_ < tensors_.size())
    throw Error(fmt::format("tensor '{}' was not written completely", tensors_[tensor_].name));
  out_.flush();
  if (!out_) throw Error("the tensors cannot be written: is the disk full?");
}

SafetensorsReader::SafetensorsReader(const std::filesystem::path& file)
    : source_(file.string()), stream_(file, std::ios::binary) {
  if (!stream_ || std::filesystem::is_directory(file))
    throw InputError(source_, "cannot be opened: is the path right?");
  stream_.seekg(0, std::ios::end);
  const auto file_bytes = static_cast<std::uint64_t>(stream_.tellg());
  stream_.seekg(0);
  std::uint64_t header_bytes = 0;
  if (!stream_.read(reinterpret_cast<char*>(&header_bytes), sizeof(header_bytes)) ||
      header_bytes > file_bytes - sizeof(header_bytes) || header_bytes > max_safetensors_header_bytes) {
    throw InputError(source_, "not a safetensors file, or truncated: fetch it again");
  }
  std::string json(header_bytes, '\0');
  if (!stream_.read(json.data(), static_cast<std::streamsize>(json.size())))
    throw InputError(source_, "cannot be read");
  data_begin_ = sizeof(header_bytes) + header_bytes;
  header_ = parse_safetensors_header(json, file_bytes - data_begin_, source_);
}

const TensorPlace& SafetensorsReader::place(const std::string& name, TensorType type) const {
  const auto it = header_.tensors.find(name);
  if (it == header_.tensors.end())
    throw InputError(source_, fmt::format("has no tensor '{}': is it the right file?", name));
  if (it->second.type != type) {
    throw InputError(source_, fmt::format("tensor '{}' is {}, need {}: is it the right file?", name,
                                          to_string(it->second.type), to_string(type)));
  }
  return it->second;
}

void SafetensorsReader::read(const TensorPlace& place, std::uint64_t first_byte, std::span<std::byte> into) {
  if (first_byte > place.size() || into.size() > place.size() - first_byte) {
    throw Error(fmt::format("{}: {} bytes from {} on are more than the tensor has", source_, into.size(), first_byte));
  }
  stream_.clear();
  stream_.seekg(static_cast<std::streamoff>(data_begin_ + place.begin + first_byte));
  if (!stream_.read(reinterpret_cast<char*>(into.data()), static_cast<std::streamsize>(into.size()))) {
    throw InputError(source_, "cannot be read to its end: was it changed meanwhile?");
  }
}

std::vector<std::uint8_t> SafetensorsReader::read_u8(const std::string& name) {
  const TensorPlace& from = place(name, TensorType::u8);
  std::vector<std::uint8_t> values(from.size());
  read(from, 0, std::as_writable_bytes(std::span(values)));
  return values;
}

std::vector<std::int64_t> SafetensorsReader::read_i64(const std::string& name) {
  const TensorPlace& from = place(name, TensorType::i64);
  std::vector<std::int64_t> values(from.size() / sizeof(std::int64_t));
  read(from, 0, std::as_writable_bytes(std::span(values)));
  return values;
}

NamedTensor SafetensorsReader::read_floats(const std::string& name) {
  const auto it = header_.tensors.find(name);
  const bool half = it != header_.tensors.end() && it->second.type == TensorType::f16;
  const TensorPlace& from = place(name, half ? TensorType::f16 : TensorType::f32);
  NamedTensor tensor{from.shape, std::vector<float>(from.size() / bytes_of(from.type)), from.type};
  if (!half) {
    read(from, 0, std::as_writable_bytes(std::span(tensor.values)));
    return tensor;
  }
  std::vector<std::uint16_t> halves(tensor.values.size());
  read(from, 0, std::as_writable_bytes(std::span(halves)));
  for (std::size_t i = 0; i < halves.size(); ++i) tensor.values[i] = float_from_half(halves[i]);
  return tensor;
}

TensorFile read_safetensors(const std::filesystem::path& file) {
  SafetensorsReader reader(file);
  TensorFile result;
  result.metadata = reader.metadata();
  for (const auto& entry : reader.tensors()) result.tensors.emplace(entry.first, reader.read_floats(entry.first));
  return result;
}

}  // namespace orthodrive
