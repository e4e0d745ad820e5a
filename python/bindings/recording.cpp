#include "palpate/record/byte_source.h"
#include "palpate/record/mcap_reader.h"
#include "palpate/record/recording_info.h"
#include "python/bindings/conversions.h"
#include "python/bindings/message_columns.h"
#include "python/bindings/module.h"

namespace palpate::python {
namespace {

// What is read of one topic.
class TopicReader : public record::ScanHandler {
 public:
  Expected<void> message(const record::HeardMessage& heard) override {
    if (!columns_) {
      if (auto ready = describe(heard); !ready) return ready;
    }
    if (!columns_->add(heard.message.data)) ++unread;
    log_time_ns.push_back(static_cast<std::int64_t>(heard.message.log_time_ns));
    return {};
  }

  std::vector<std::int64_t> log_time_ns;
  std::string schema;
  std::uint64_t unread = 0;  // messages that are not what they should be
  std::vector<std::pair<std::string, Column>> take() {
    return columns_ ? columns_->take() : std::vector<std::pair<std::string, Column>>{};
  }

 private:
  Expected<void> describe(const record::HeardMessage& heard) {
    if (heard.schema == nullptr || heard.schema->encoding != "protobuf")
      return refused("{}: its messages are of '{}', protobuf is expected", heard.channel.topic,
                     heard.channel.message_encoding);
    auto types = message_types(heard.schema->data);
    if (!types) return tl::unexpected(types.error());
    types_ = std::make_unique<MessageTypes>(std::move(*types));
    schema = heard.schema->name;
    auto columns = MessageColumns::of(*types_, schema);
    if (!columns) return tl::unexpected(columns.error());
    columns_.emplace(std::move(*columns));
    return {};
  }

  std::unique_ptr<MessageTypes> types_;
  std::optional<MessageColumns> columns_;
};

template <typename To, typename From>
py::array ragged(const std::vector<From>& values, const std::vector<std::size_t>& ends, To nothing) {
  std::size_t width = 0, begin = 0;
  for (const auto end : ends) width = std::max(width, end - begin), begin = end;
  py::array_t<To> array({static_cast<py::ssize_t>(ends.size()), static_cast<py::ssize_t>(width)});
  To* to = array.mutable_data();
  begin = 0;
  for (const auto end : ends) {
    for (std::size_t k = 0; k < width; ++k)
      *to++ = begin + k < end ? static_cast<To>(values[begin + k]) : nothing;
    begin = end;
  }
  return read_only(std::move(array));
}

template <typename To, typename From>
py::array flat(const std::vector<From>& values) {
  py::array_t<To> array(static_cast<py::ssize_t>(values.size()));
  std::transform(values.begin(), values.end(), array.mutable_data(),
                 [](From value) { return static_cast<To>(value); });
  return read_only(std::move(array));
}

template <typename To, typename From>
py::array numbers(const std::vector<From>& values, const Column& column, To nothing) {
  return column.repeated ? ragged<To>(values, column.ends, nothing) : flat<To>(values);
}

py::object object_of(const Column& column) {
  switch (column.kind) {
    case Column::Kind::real:
      return numbers<double>(column.reals, column, std::numeric_limits<double>::quiet_NaN());
    case Column::Kind::integer:
      return numbers<std::int64_t>(column.integers, column, std::int64_t{0});
    case Column::Kind::whole:
      return numbers<std::uint64_t>(column.integers, column, std::uint64_t{0});
    case Column::Kind::flag:
      return numbers<bool>(column.integers, column, false);
    case Column::Kind::text:
      break;
  }
  py::list texts;
  for (const auto& text : column.texts) texts.append(python::object_of(Json(text)));
  return texts;
}

py::dict recording_info(const std::string& path) {
  const auto found = unlocked([&]() -> Expected<record::RecordingInfo> {
    auto source = record::open_source(path);
    if (!source) return tl::unexpected(source.error());
    return record::info(**source);
  });
  if (!found) throw Failure{found.error()};
  py::dict topics;
  for (const auto& stream : found->streams)
    topics[py::str(stream.name)] = py::make_tuple(stream.messages, stream.dropped, stream.rate_hz);
  std::vector<std::string> faults;
  for (const auto& fault : found->scanned.faults)
    faults.push_back(fmt::format("byte {}: {}", fault.offset, fault.words));
  py::dict fields;
  fields["topics"] = topics;
  fields["seconds"] = found->seconds;
  fields["start_ns"] = found->scanned.found.start_ns;
  fields["version"] = found->version;
  fields["faults"] = faults;
  return fields;
}

py::dict recording_topic(const std::string& path, const std::string& topic, std::uint64_t from_ns,
                         std::uint64_t to_ns) {
  TopicReader reader;
  std::vector<std::pair<std::string, Column>> columns;
  const auto done = unlocked([&]() -> Expected<void> {
    auto source = record::open_source(path);
    if (!source) return tl::unexpected(source.error());
    const auto scanned =
        record::scan(**source, {.topics = {topic}, .from_ns = from_ns, .to_ns = to_ns}, reader);
    if (!scanned) return tl::unexpected(scanned.error());
    columns = reader.take();
    return {};
  });
  if (!done) throw Failure{done.error()};
  py::dict fields, table;
  for (const auto& [name, column] : columns) table[py::str(name)] = object_of(column);
  fields["columns"] = table;
  fields["log_time_ns"] = flat<std::int64_t>(reader.log_time_ns);
  fields["schema"] = reader.schema;
  fields["unread"] = reader.unread;
  return fields;
}

}  // namespace

void add_recordings(py::module_& module) {
  module.def("recording_info", &recording_info);
  module.def("recording_topic", &recording_topic);
}

}  // namespace palpate::python
