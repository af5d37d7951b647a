#include <lcmslam/recordings/mcap_writer.hpp>

#include <fcntl.h>
#include <algorithm>
#include <cerrno>
#include <utility>

#include <lcmslam/recordings/compression.hpp>
#include <lcmslam/recordings/mcap_format.hpp>

namespace lcmslam {
namespace {

using mcap::Record;
using Bytes = std::vector<std::uint8_t>;

Bytes make_record(Record kind, const ByteWriter& content) {
  ByteWriter record;
  record.number(kind);
  record.number(static_cast<std::uint64_t>(content.bytes().size()));
  record.raw(content.view());
  return record.bytes();
}

ByteView view(const Bytes& bytes) {
  return {bytes.data(), bytes.size()};
}

std::uint16_t number_of(std::size_t index) {
  return static_cast<std::uint16_t>(index + 1);  // 0 is no schema
}

}  // namespace

void McapWriter::Times::add(std::int64_t time) {
  first = any ? std::min(first, time) : time;
  last = any ? std::max(last, time) : time;
  any = true;
}

McapWriter::McapWriter(const std::string& file, const Options& options) : file_(file), options_(options) {
  try {
    part_ = std::make_unique<PartFile>(FilePlace(file));
  } catch (const std::exception& error) {
    throw std::runtime_error(file_ + ": cannot be written: " + error.what());
  }
  stream_ = fdopen(fcntl(part_->descriptor(), F_DUPFD_CLOEXEC, 0), "wb");
  if (stream_ == nullptr) throw std::runtime_error(file_ + ": cannot be written: " + std::strerror(errno));
  ByteWriter header;
  header.text("ros2");
  header.text("lcmslam");
  write_bytes({reinterpret_cast<const std::uint8_t*>(mcap::magic.data()), mcap::magic.size()});
  write_bytes(view(make_record(Record::header, header)));
}

McapWriter::~McapWriter() {
  if (stream_ != nullptr) std::fclose(stream_);
}

std::uint16_t McapWriter::add_channel(const std::string& topic, const std::string& type,
                                      const std::string& definition) {
  Channel channel;
  const auto [known, is_new] = schemas_.emplace(type, number_of(schemas_.size()));
  if (is_new) {
    ByteWriter schema;
    schema.number(known->second);
    schema.text(type);
    schema.text("ros2msg");
    schema.text(definition);
    channel.schema_record = make_record(Record::schema, schema);
  }
  const std::uint16_t id = number_of(channels_.size());
  ByteWriter content;
  content.number(id);
  content.number(known->second);
  content.text(topic);
  content.text("cdr");
  content.text("");  // no metadata
  channel.channel_record = make_record(Record::channel, content);
  chunk_.raw(view(channel.schema_record));
  chunk_.raw(view(channel.channel_record));
  channels_.push_back(std::move(channel));
  return id;
}

void McapWriter::write(std::uint16_t channel, std::int64_t log_time, std::int64_t publish_time,
                       ByteView message) {
  Channel& of = channels_.at(channel - 1U);
  ByteWriter content;
  content.number(channel);
  content.number(of.sequence++);
  content.number(log_time);
  content.number(publish_time);
  content.raw(message);
  ++of.messages;
  times_.add(log_time);
  chunk_times_.add(log_time);
  chunk_index_[channel].push_back({log_time, chunk_.bytes().size()});
  chunk_.raw(view(make_record(Record::message, content)));
  if (chunk_.bytes().size() >= options_.chunk_size) write_chunk();
}

/// The chunk, where each channel's messages lie in it, and a record for the summary that leads there.
void McapWriter::write_chunk() {
  if (chunk_.bytes().empty()) return;
  const Bytes packed = pack(options_.compression, chunk_.view());
  const std::uint64_t begin = position_;
  ByteWriter content;
  content.number(chunk_times_.first);
  content.number(chunk_times_.last);
  content.number(static_cast<std::uint64_t>(chunk_.bytes().size()));
  content.number(crc32(chunk_.view()));
  content.text(options_.compression);
  content.number(static_cast<std::uint64_t>(packed.size()));
  content.raw(view(packed));
  write_bytes(view(make_record(Record::chunk, content)));
  const std::uint64_t end = position_;

  ByteWriter offsets;  // of the indexes, by channel
  for (auto& [channel, entries] : chunk_index_) {
    std::stable_sort(entries.begin(), entries.end(), [](auto& a, auto& b) { return a.time < b.time; });
    offsets.number(channel);
    offsets.number(position_);
    ByteWriter index;
    index.number(channel);
    index.number(static_cast<std::uint32_t>(entries.size() * 16));
    for (const IndexEntry& entry : entries) {
      index.number(entry.time);
      index.number(entry.offset);
    }
    write_bytes(view(make_record(Record::message_index, index)));
  }

  ByteWriter summary;
  summary.number(chunk_times_.first);
  summary.number(chunk_times_.last);
  summary.number(begin);
  summary.number(end - begin);
  summary.text(offsets.view().text());
  summary.number(position_ - end);
  summary.text(options_.compression);
  summary.number(static_cast<std::uint64_t>(packed.size()));
  summary.number(static_cast<std::uint64_t>(chunk_.bytes().size()));
  chunk_index_records_.push_back(make_record(Record::chunk_index, summary));
  chunk_.clear();
  chunk_times_ = {};
  chunk_index_.clear();
}

/// What the file holds, all of it again or by its place, so that readers need not look through it.
void McapWriter::write_summary() {
  crc_ = 0;
  const std::uint64_t begin = position_;
  ByteWriter offsets;
  const auto write_group = [&](Record kind, const std::vector<Bytes>& records) {
    const std::uint64_t group = position_;
    for (const Bytes& record : records) write_bytes(view(record));
    if (position_ == group) return;
    ByteWriter offset;
    offset.number(kind);
    offset.number(group);
    offset.number(position_ - group);
    offsets.raw(view(make_record(Record::summary_offset, offset)));
  };
  std::vector<Bytes> schemas, channels;
  ByteWriter counts;
  std::uint64_t messages = 0;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    schemas.push_back(channels_[i].schema_record);
    channels.push_back(channels_[i].channel_record);
    counts.number(number_of(i));
    counts.number(channels_[i].messages);
    messages += channels_[i].messages;
  }
  ByteWriter statistics;
  statistics.number(messages);
  statistics.number(static_cast<std::uint16_t>(schemas_.size()));
  statistics.number(static_cast<std::uint32_t>(channels_.size()));
  statistics.number(std::uint32_t{0});  // attachments
  statistics.number(std::uint32_t{0});  // metadata
  statistics.number(static_cast<std::uint32_t>(chunk_index_records_.size()));
  statistics.number(times_.first);
  statistics.number(times_.last);
  statistics.text(counts.view().text());
  write_group(Record::schema, schemas);
  write_group(Record::channel, channels);
  write_group(Record::statistics, {make_record(Record::statistics, statistics)});
  write_group(Record::chunk_index, chunk_index_records_);

  const std::uint64_t offsets_begin = position_;
  write_bytes(offsets.view());
  ByteWriter footer;
  footer.number(Record::footer);
  footer.number(static_cast<std::uint64_t>(mcap::footer_size));
  footer.number(begin);
  footer.number(offsets_begin);
  write_bytes(footer.view());
  ByteWriter crc;
  crc.number(crc_);
  write_bytes(crc.view());
}

void McapWriter::close() {
  write_chunk();
  ByteWriter end;
  end.number(crc_);
  write_bytes(view(make_record(Record::data_end, end)));
  write_summary();
  write_bytes({reinterpret_cast<const std::uint8_t*>(mcap::magic.data()), mcap::magic.size()});
  if (std::fclose(std::exchange(stream_, nullptr)) != 0)
    throw std::runtime_error(file_ + ": cannot be written: " + std::strerror(errno));
  try {
    part_->flush();
    part_->take_name();
  } catch (const std::exception& error) {
    throw std::runtime_error(file_ + ": cannot be written: " + error.what());
  }
}

void McapWriter::write_bytes(ByteView bytes) {
  if (bytes.size > 0 && std::fwrite(bytes.data, 1, bytes.size, stream_) != bytes.size)
    throw std::runtime_error(file_ + ": cannot be written: " + std::strerror(errno));
  position_ += bytes.size;
  crc_ = crc32(bytes, crc_);
}

}  // namespace lcmslam
