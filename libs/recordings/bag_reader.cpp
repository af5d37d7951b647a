// Bags of ROS 1, format 2.0 (wiki.ros.org/Bags/Format/2.0), read from the front: bags that were not closed
// (.bag.active) have no index. A record is a header of fields "name=value" and data, a length before each.
//
// Debian has a library for them (librosbag-storage), which loads Python's interpreter through librospack and
// trusts the lengths in the file; hence this page.

#include <map>
#include <optional>

#include <lcmslam/recordings/compression.hpp>
#include <lcmslam/recordings/recording_file.hpp>

namespace lcmslam {
namespace {

constexpr std::string_view bag_magic = "#ROSBAG V2.0\n";

enum class BagOp : std::uint8_t {
  message = 2,
  header = 3,
  index = 4,
  chunk = 5,
  chunk_info = 6,
  connection = 7
};

/// Fields "name=value", a length before each.
class Fields {
 public:
  explicit Fields(ByteView bytes) {
    ByteReader reader(bytes);
    while (!reader.done()) {
      const ByteView field = reader.sized<std::uint32_t>();
      const std::size_t equals = field.text().find('=');
      if (equals == std::string_view::npos) throw RecordingError("a field without '='");
      fields_[std::string(field.text().substr(0, equals))] = {field.data + equals + 1,
                                                              field.size - equals - 1};
    }
  }

  template <class T>
  T number(const std::string& name) const {
    return ByteReader(at(name)).number<T>();
  }
  std::string text(const std::string& name) const { return std::string(at(name).text()); }
  bool has(const std::string& name) const { return fields_.count(name) > 0; }

 private:
  ByteView at(const std::string& name) const {
    const auto found = fields_.find(name);
    if (found == fields_.end()) throw RecordingError("a record without the field " + name);
    return found->second;
  }
  std::map<std::string, ByteView> fields_;
};

struct BagRecord {
  ByteView header, data;
  std::uint64_t at = 0, data_at = 0;  // of the record, of its data
};

/// The next record; nothing when its bytes are not all there.
std::optional<BagRecord> next_bag_record(ByteReader& bytes) {
  BagRecord record;
  record.at = bytes.position();
  try {
    record.header = bytes.sized<std::uint32_t>();
    record.data = bytes.sized<std::uint32_t>();
  } catch (const RecordingError&) {
    return std::nullopt;
  }
  record.data_at = bytes.position() - record.data.size;
  return record;
}

class BagReader : public RecordingFile {
 public:
  BagReader(ByteView bytes, std::uint64_t largest_chunk) : RecordingFile(bytes, largest_chunk) {
    const std::string_view text = bytes.text().substr(0, bag_magic.size());
    if (text == bag_magic) return;
    const bool is_other = text.substr(0, 8) == bag_magic.substr(0, 8);
    throw RecordingError(is_other ? "is a bag of another version than 2.0: rosbag migrates it"
                                  : "is no bag: it does not begin with #ROSBAG V2.0");
  }

  void scan(const Visitor& visit) override {
    ByteReader bytes(bytes_);
    bytes.take(bag_magic.size());
    while (!bytes.done()) {
      const std::size_t begin = bytes.position();
      const auto record = next_bag_record(bytes);
      if (!record) {
        damage(begin, "a record ends behind the file: the file is cut off or damaged");
        return;
      }
      guarded(record->at, [&] {
        const Fields fields(record->header);
        if (kind(fields) == BagOp::chunk)
          scan_chunk(*record, visit);
        else
          take(*record, fields, 0, visit);
      });
    }
  }

 private:
  static BagOp kind(const Fields& fields) { return static_cast<BagOp>(fields.number<std::uint8_t>("op")); }

  Bytes unpack_chunk(std::uint64_t place) const override {
    ByteReader bytes(bytes_);
    bytes.take(place);
    const auto record = next_bag_record(bytes);
    if (!record) throw RecordingError("a chunk's bytes are not all there");
    const Fields fields(record->header);
    const auto size = fields.number<std::uint32_t>("size");
    check_chunk_size(size);
    return unpack(fields.text("compression"), record->data, size);
  }

  void scan_chunk(const BagRecord& record, const Visitor& visit) {
    const Bytes& unpacked = chunk(record.at);
    ByteReader bytes({unpacked.data(), unpacked.size()});
    while (!bytes.done()) {
      const auto inner = next_bag_record(bytes);
      if (!inner) throw RecordingError("a record ends behind its chunk");
      guarded(record.at, [&] { take(*inner, Fields(inner->header), record.at, visit); });
    }
  }

  /// Indexes and their like are passed over.
  void take(const BagRecord& record, const Fields& fields, std::uint64_t chunk, const Visitor& visit) {
    switch (kind(fields)) {
      case BagOp::header:
        if (fields.has("encryptor") && !fields.text("encryptor").empty())
          throw RecordingError("the bag is encrypted by " + fields.text("encryptor") +
                               ": rosbag decrypt writes one that is not");
        return;
      case BagOp::connection:
        take_connection(record, fields);
        return;
      case BagOp::message:
        take_message(record, fields, chunk, visit);
        return;
      default:
        return;
    }
  }

  void take_connection(const BagRecord& record, const Fields& fields) {
    const auto id = fields.number<std::uint32_t>("conn");
    const std::size_t topic = add_topic({fields.text("topic"), Fields(record.data).text("type"), "ros1"});
    if (const auto known = connections_.emplace(id, topic).first; known->second != topic)
      throw RecordingError("connection " + std::to_string(id) + " is " + topics()[known->second].name +
                           " already and cannot be " + topics()[topic].name);
  }

  void take_message(const BagRecord& record, const Fields& fields, std::uint64_t chunk,
                    const Visitor& visit) {
    const auto connection = connections_.find(fields.number<std::uint32_t>("conn"));
    if (connection == connections_.end())
      throw RecordingError("a message of a connection that nothing describes");
    const auto time = fields.number<std::uint64_t>("time");  // s below, ns above
    RecordedMessage message;
    message.topic = connection->second;
    message.log_time = static_cast<std::int64_t>((time & 0xffffffff) * 1'000'000'000 + (time >> 32));
    message.chunk = chunk;
    message.offset = record.data_at;
    message.size = record.data.size;
    visit(message, record.data);
  }

  std::map<std::uint32_t, std::size_t> connections_;  // -> topics()
};

}  // namespace

std::unique_ptr<RecordingFile> open_bag(ByteView bytes, std::uint64_t largest_chunk) {
  return std::make_unique<BagReader>(bytes, largest_chunk);
}

}  // namespace lcmslam
