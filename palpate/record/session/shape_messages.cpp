#include "palpate/record/session/shape_messages.h"

#include <algorithm>
#include <cstring>
#include <functional>

#include "palpate/record/session/internal/message_parts.h"

namespace palpate::record::session {
namespace {

constexpr auto kFloats = scene::Shape::kFloatsPerVertex;

bool moved(const scene::Shape& now, const scene::Shape& before, std::size_t vertex) {
  return std::memcmp(&now.values[kFloats * vertex], &before.values[kFloats * vertex],
                     kFloats * sizeof(float)) != 0;
}

}  // namespace

std::string ShapeEncoder::encode(const scene::Shape& shape) {
  recording::Shape out;
  out.set_time_ns(shape.time.ns());
  out.set_vertices(static_cast<std::uint32_t>(shape.vertices()));
  const bool whole = last_.values.size() != shape.values.size() || shape.time >= next_whole_;
  out.set_whole(whole);
  if (whole) {
    out.mutable_values()->Add(shape.values.begin(), shape.values.end());
    next_whole_ = shape.time + kWholeEvery;
  } else {
    for (std::size_t i = 0; i < shape.vertices(); ++i) {
      if (!moved(shape, last_, i)) continue;
      const float* numbers = &shape.values[kFloats * i];
      out.add_moved(static_cast<std::uint32_t>(i));
      out.mutable_values()->Add(numbers, numbers + kFloats);
    }
  }
  last_ = shape;
  return out.SerializeAsString();
}

Expected<bool> ShapeDecoder::decode(std::string_view bytes) {
  const auto in = parse<recording::Shape>(bytes, "a Shape");
  if (!in) return tl::unexpected(in.error());
  const std::size_t vertices = in->vertices();
  if (vertices == 0 || vertices > scene::Shape::kMaxVertices)
    return refused("a Shape has {} vertices; 1 to {} are expected", vertices, scene::Shape::kMaxVertices);
  const std::size_t told = in->whole() ? vertices : static_cast<std::size_t>(in->moved_size());
  if (static_cast<std::size_t>(in->values_size()) != kFloats * told)
    return refused("a Shape has {} values where {} are expected", in->values_size(), kFloats * told);
  if (in->whole()) {
    shape_ = {Instant<PhysicsClock>{Duration(in->time_ns())}, {in->values().begin(), in->values().end()}};
    return true;
  }
  const bool ordered =
      std::adjacent_find(in->moved().begin(), in->moved().end(), std::greater_equal<>()) == in->moved().end();
  if (!ordered || (told > 0 && *in->moved().rbegin() >= vertices))
    return refused("a Shape names vertices out of order, or one of more than {}", vertices);
  if (shape_.vertices() != vertices) return false;
  shape_.time = Instant<PhysicsClock>{Duration(in->time_ns())};
  for (std::size_t k = 0; k < told; ++k)
    std::copy_n(in->values().begin() + static_cast<std::ptrdiff_t>(kFloats * k), kFloats,
                &shape_.values[kFloats * in->moved(static_cast<int>(k))]);
  return true;
}

}  // namespace palpate::record::session
