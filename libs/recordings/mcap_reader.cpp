// MCAP files, read from the front: what a recorder that died has left has neither index nor footer.

#include <map>
#include <optional>

#include <lcmslam/recordings/compression.hpp>
#include <lcmslam/recordings/mcap_format.hpp>
#include <lcmslam/recordings/recording_file.hpp>

namespace lcmslam {
namespace {

using mcap::Record;

struct McapRecord {
  Record kind = Record::header;
  ByteView content;
  std::uint64_t at = 0;  // of the record among the bytes that it was read from
};

/// The next record; nothing when its bytes are not all there.
std::optional<McapRecord> next_record(ByteReader& bytes) {
  const std::uint64_t at = bytes.position();
  if (bytes.left() < mcap::record_head) return std::nullopt;
  const auto kind = static_cast<Record>(bytes.number<std::uint8_t>());
  const auto size = bytes.number<std::uint64_t>();
  if (size > bytes.left()) return std::nullopt;
  return McapRecord{kind, bytes.take(size), at};
}

class McapReader : public RecordingFile {
 public:
  McapReader(ByteView bytes, std::uint64_t largest_chunk) : RecordingFile(bytes, largest_chunk) {
    if (bytes.text().substr(0, mcap::magic.size()) != mcap::magic)
      throw RecordingError("is no MCAP file: it does not begin with \\x89MCAP0\\r\\n");
  }

  void scan(const Visitor& visit) override {
    read_summary();
    ByteReader bytes(bytes_);
    bytes.take(mcap::magic.size());
    bool in_summary = false;
    while (!bytes.done()) {
      const auto record = next_record(bytes);
      if (!record) {
        damage(bytes.position(), "a record ends behind the file: the file is cut off or damaged");
        return;
      }
      if (record->kind == Record::footer) {
        if (!whole_summary(*record)) damage(record->at, "the summary is damaged: it does not have its CRC");
        return;
      }
      if (in_summary) continue;
      in_summary = record->kind == Record::data_end;
      guarded(record->at, [&] {
        if (record->kind == Record::chunk)
          scan_chunk(*record, visit);
        else if (record->kind == Record::data_end)
          check_data(*record);
        else
          take(*record, 0, visit);
      });
    }
    damage(bytes_.size, "ends without a footer: its recorder did not close it");
  }

 private:
  struct Schema {
    std::string name, encoding;
  };

  Bytes unpack_chunk(std::uint64_t place) const override {
    ByteReader bytes(bytes_);
    bytes.take(place);
    const auto record = next_record(bytes);
    if (!record) throw RecordingError("a chunk's bytes are not all there");
    ByteReader content(record->content);
    content.take(16);  // its times
    const auto size = content.number<std::uint64_t>();
    const auto crc = content.number<std::uint32_t>();
    const std::string compression = content.text();
    check_chunk_size(size);
    Bytes unpacked = unpack(compression, content.sized<std::uint64_t>(), size);
    if (crc != 0 && crc32({unpacked.data(), unpacked.size()}) != crc)
      throw RecordingError("a chunk's bytes are damaged: they do not have its CRC");
    return unpacked;
  }

  void scan_chunk(const McapRecord& record, const Visitor& visit) {
    const Bytes& unpacked = chunk(record.at);
    ByteReader bytes({unpacked.data(), unpacked.size()});
    while (!bytes.done()) {
      const auto inner = next_record(bytes);
      if (!inner) throw RecordingError("a record ends behind its chunk");
      guarded(record.at, [&] { take(*inner, record.at, visit); });
    }
  }

  /// Records of which a chunk may consist; others (indexes, attachments, those of other versions) are passed
  /// over.
  void take(const McapRecord& record, std::uint64_t chunk, const Visitor& visit) {
    ByteReader content(record.content);
    if (record.kind == Record::schema) {
      const auto id = content.number<std::uint16_t>();
      const std::string name = content.text();
      schemas_[id] = {name, content.text()};
    } else if (record.kind == Record::channel) {
      take_channel(content);
    } else if (record.kind == Record::message) {
      const auto id = content.number<std::uint16_t>();
      const auto channel = channels_.find(id);
      if (channel == channels_.end()) throw RecordingError("a message of a channel that nothing describes");
      RecordedMessage message;
      message.topic = channel->second;
      content.take(4);  // its number
      message.log_time = content.number<std::int64_t>();
      content.take(8);  // when it was sent, by the recorder's clock
      message.chunk = chunk;
      message.offset = record.at + mcap::record_head + content.position();
      message.size = content.left();
      visit(message, content.take(content.left()));
    }
  }

  void take_channel(ByteReader& content) {
    const auto id = content.number<std::uint16_t>();
    const auto schema = schemas_.find(content.number<std::uint16_t>());
    RecordedTopic topic;
    topic.name = content.text();
    topic.encoding = content.text();
    if (schema != schemas_.end()) topic.type = schema->second.name;
    const auto known = channels_.find(id);
    if (known == channels_.end()) {
      channels_[id] = add_topic(topic);
    } else if (const RecordedTopic& first = topics()[known->second];
               first.name != topic.name || first.encoding != topic.encoding) {
      throw RecordingError("channel " + std::to_string(id) + " is " + first.name + " already and cannot be " +
                           topic.name);
    }
  }

  void check_data(const McapRecord& record) const {
    const auto crc = ByteReader(record.content).number<std::uint32_t>();
    if (crc != 0 && crc32({bytes_.data, static_cast<std::size_t>(record.at)}) != crc)
      throw RecordingError("the data up to here are damaged: they do not have their CRC");
  }

  /// The summary that a footer speaks of, with the footer's head; nothing when it is damaged.
  std::optional<ByteView> whole_summary(const McapRecord& footer) const {
    if (footer.content.size != mcap::footer_size) return std::nullopt;
    ByteReader content(footer.content);
    const auto begin = content.number<std::uint64_t>();
    content.take(8);
    const auto crc = content.number<std::uint32_t>();
    const std::uint64_t from = begin == 0 ? footer.at : begin;
    const std::uint64_t end = footer.at + mcap::record_head + 16;
    if (from > footer.at) return std::nullopt;
    const ByteView summary{bytes_.data + from, static_cast<std::size_t>(end - from)};
    return crc == 0 || crc32(summary) == crc ? std::optional(summary) : std::nullopt;
  }

  /// Types and topics stand there once more: a chunk that is damaged does not take them along.
  void read_summary() {
    constexpr std::size_t tail = mcap::record_head + mcap::footer_size + mcap::magic.size();
    if (bytes_.size < mcap::magic.size() + tail) return;
    ByteReader bytes(bytes_);
    bytes.take(bytes_.size - tail);
    const auto footer = next_record(bytes);
    if (!footer || footer->kind != Record::footer) return;
    const auto summary = whole_summary(*footer);
    if (!summary) return;
    ByteReader records(*summary);
    while (const auto record = next_record(records))
      if (record->kind == Record::schema || record->kind == Record::channel)
        guarded(record->at, [&] { take(*record, 0, nullptr); });
  }

  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, std::size_t> channels_;  // -> topics()
};

}  // namespace

std::unique_ptr<RecordingFile> open_mcap(ByteView bytes, std::uint64_t largest_chunk) {
  return std::make_unique<McapReader>(bytes, largest_chunk);
}

}  // namespace lcmslam
