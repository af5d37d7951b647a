#include <lcmslam/features/descriptor_index.hpp>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace lcmslam {
namespace {

constexpr int largest_id = (1 << 24) - 1;
constexpr std::size_t capacity = DescriptorIndex::list_capacity;
constexpr std::size_t smallest_part = capacity / 8;  // of a split; below it a list is dissolved

[[noreturn]] void refuse(int id, const std::string& what) {
  throw std::invalid_argument("descriptor index: id " + std::to_string(id) + " " + what);
}

// Distances of all members to two centres.
void distances_to(DistanceFunction distances_of, const Descriptor& first, const Descriptor& second,
                  const DescriptorIndex::List& list, Int4* distances) {
  WideDescriptor wide[2];
  wide[0].assign(first);
  wide[1].assign(second);
  const WideDescriptor* const queries[4] = {&wide[0], &wide[1], &wide[0], &wide[1]};
  distances_of(queries, list.descriptors.data(), list.norms2.data(), static_cast<int>(list.ids.size()),
               distances);
}

Descriptor mean_of(const DescriptorIndex::List& list, const std::vector<bool>& second, bool which) {
  int sums[64] = {}, count = 0;
  for (std::size_t i = 0; i < list.ids.size(); ++i) {
    if (second[i] != which) continue;
    ++count;
    for (std::size_t k = 0; k < 64; ++k) sums[k] += list.descriptors[i][k];
  }
  Descriptor mean{};
  for (std::size_t k = 0; k < 64 && count > 0; ++k)
    mean[k] = static_cast<std::uint8_t>((sums[k] + count / 2) / count);
  return mean;
}

std::size_t farthest(const Int4* distances, std::size_t count) {
  std::size_t result = 0;
  for (std::size_t i = 1; i < count; ++i)
    if (distances[i][0] > distances[result][0]) result = i;
  return result;
}

// Two-means from the pair of members that is about the farthest apart. Whatever the data (twins, a lone
// stranger) no part is small.
std::vector<bool> halves(DistanceFunction distances_of, const DescriptorIndex::List& list) {
  const std::size_t count = list.ids.size();
  Int4 distances[capacity];
  std::vector<bool> second(count, false);
  const Descriptor middle = mean_of(list, second, false);
  distances_to(distances_of, middle, middle, list, distances);
  Descriptor centre_a = list.descriptors[farthest(distances, count)];
  distances_to(distances_of, centre_a, centre_a, list, distances);
  Descriptor centre_b = list.descriptors[farthest(distances, count)];
  constexpr int rounds = 4;
  for (int round = 0; round < rounds; ++round) {
    distances_to(distances_of, centre_a, centre_b, list, distances);
    for (std::size_t i = 0; i < count; ++i) second[i] = distances[i][1] < distances[i][0];
    centre_a = mean_of(list, second, false);
    centre_b = mean_of(list, second, true);
  }
  const auto in_second = static_cast<std::size_t>(std::count(second.begin(), second.end(), true));
  if (in_second >= smallest_part && count - in_second >= smallest_part) return second;
  std::vector<std::pair<int, std::size_t>> order;
  for (std::size_t i = 0; i < count; ++i) order.emplace_back(distances[i][0] - distances[i][1], i);
  std::sort(order.begin(), order.end());
  for (std::size_t i = 0; i < count; ++i) second[order[i].second] = i >= count / 2;
  return second;
}

void reserve(DescriptorIndex::List& list) {
  list.descriptors.reserve(capacity);
  list.norms2.reserve(capacity);
  list.ids.reserve(capacity);
}

}  // namespace

void DescriptorIndex::insert(int id, const Descriptor& descriptor, int laplacian) {
  if (id < 0 || id > largest_id) refuse(id, "must be 0 to " + std::to_string(largest_id));
  if (contains(id)) refuse(id, "is in the index already");
  if (static_cast<std::size_t>(id) >= places_.size()) places_.resize(static_cast<std::size_t>(id) + 1);
  const int sign = laplacian < 0 ? 0 : 1;
  insert_into(by_sign_[sign], sign, id, descriptor);
}

void DescriptorIndex::update(int id, const Descriptor& descriptor) {
  const int sign = place(id).sign;
  const Descriptor copy = descriptor;  // it may be one of ours
  remove(id);
  insert_into(by_sign_[sign], sign, id, copy);
}

void DescriptorIndex::remove(int id) {
  const Place at = place(id);
  Lists& lists = by_sign_[at.sign];
  const auto number = static_cast<std::size_t>(at.list);
  List& list = lists.lists[number];
  const auto position = static_cast<std::size_t>(at.position);
  list.descriptors[position] = list.descriptors.back();
  list.norms2[position] = list.norms2.back();
  list.ids[position] = list.ids.back();
  places_[static_cast<std::size_t>(list.ids[position])].position = at.position;
  list.descriptors.pop_back();
  list.norms2.pop_back();
  list.ids.pop_back();
  places_[static_cast<std::size_t>(id)] = {};
  --lists.size;
  if (list.ids.empty() || (list.ids.size() < smallest_part && lists.lists.size() > 1))
    dissolve(lists, at.sign, number);
}

bool DescriptorIndex::contains(int id) const {
  return id >= 0 && static_cast<std::size_t>(id) < places_.size() &&
         places_[static_cast<std::size_t>(id)].list >= 0;
}

const Descriptor& DescriptorIndex::descriptor(int id) const {
  const Place& at = place(id);
  return by_sign_[at.sign]
      .lists[static_cast<std::size_t>(at.list)]
      .descriptors[static_cast<std::size_t>(at.position)];
}

bool DescriptorIndex::is_dark(int id) const {
  return place(id).sign == 1;
}

const DescriptorIndex::Place& DescriptorIndex::place(int id) const {
  if (!contains(id)) refuse(id, "is not in the index");
  return places_[static_cast<std::size_t>(id)];
}

std::size_t DescriptorIndex::memory_bytes() const {
  std::size_t bytes = sizeof *this + places_.capacity() * sizeof(Place);
  for (const Lists& lists : by_sign_) {
    bytes += lists.centres.capacity() * sizeof(Descriptor) + lists.centre_norms2.capacity() * 4 +
             lists.lists.capacity() * sizeof(List);
    for (const List& list : lists.lists)
      bytes += list.descriptors.capacity() * sizeof(Descriptor) + list.norms2.capacity() * 4 +
               list.ids.capacity() * 4;
  }
  return bytes;
}

void DescriptorIndex::insert_into(Lists& lists, int sign, int id, const Descriptor& descriptor) {
  if (lists.lists.empty()) {
    lists.centres.push_back(descriptor);
    lists.centre_norms2.push_back(squared_norm(descriptor));
    reserve(lists.lists.emplace_back());
  }
  const std::size_t list = nearest_centre(lists, descriptor);
  append(lists, sign, list, id, descriptor);
  ++lists.size;
  if (lists.lists[list].ids.size() == capacity) split(lists, sign, list);
}

// Of equally near ones the first.
std::size_t DescriptorIndex::nearest_centre(const Lists& lists, const Descriptor& descriptor) {
  WideDescriptor wide;
  wide.assign(descriptor);
  std::int32_t distances[256];
  int nearest = std::numeric_limits<int>::max();
  std::size_t result = 0;
  for (std::size_t first = 0; first < lists.centres.size(); first += std::size(distances)) {
    const std::size_t count = std::min(std::size(distances), lists.centres.size() - first);
    lone_distances_(wide, lists.centres.data() + first, lists.centre_norms2.data() + first,
                    static_cast<int>(count), distances);
    for (std::size_t i = 0; i < count; ++i)
      if (distances[i] < nearest) {
        nearest = distances[i];
        result = first + i;
      }
  }
  return result;
}

void DescriptorIndex::append(Lists& lists, int sign, std::size_t number, int id,
                             const Descriptor& descriptor) {
  List& list = lists.lists[number];
  places_[static_cast<std::size_t>(id)] = {static_cast<std::int32_t>(number),
                                           static_cast<std::int16_t>(list.ids.size()),
                                           static_cast<std::int16_t>(sign)};
  list.descriptors.push_back(descriptor);
  list.norms2.push_back(squared_norm(descriptor));
  list.ids.push_back(id);
}

void DescriptorIndex::split(Lists& lists, int sign, std::size_t number) {
  List old;
  reserve(old);
  std::swap(old, lists.lists[number]);
  const std::vector<bool> second = halves(distances_, old);
  const Descriptor centre = mean_of(old, second, false), new_centre = mean_of(old, second, true);
  lists.centres[number] = centre;
  lists.centre_norms2[number] = squared_norm(centre);
  lists.centres.push_back(new_centre);
  lists.centre_norms2.push_back(squared_norm(new_centre));
  reserve(lists.lists.emplace_back());
  for (std::size_t i = 0; i < old.ids.size(); ++i)
    append(lists, sign, second[i] ? lists.lists.size() - 1 : number, old.ids[i], old.descriptors[i]);
}

// Its few members go to the nearest other lists, the last list takes its number.
void DescriptorIndex::dissolve(Lists& lists, int sign, std::size_t number) {
  const List old = std::move(lists.lists[number]);
  if (number + 1 < lists.lists.size()) lists.lists[number] = std::move(lists.lists.back());
  lists.centres[number] = lists.centres.back();
  lists.centre_norms2[number] = lists.centre_norms2.back();
  lists.lists.pop_back();
  lists.centres.pop_back();
  lists.centre_norms2.pop_back();
  if (number < lists.lists.size()) renumber(lists, sign, number);
  lists.size -= static_cast<int>(old.ids.size());
  for (std::size_t i = 0; i < old.ids.size(); ++i) insert_into(lists, sign, old.ids[i], old.descriptors[i]);
}

void DescriptorIndex::renumber(const Lists& lists, int sign, std::size_t number) {
  const List& list = lists.lists[number];
  for (std::size_t i = 0; i < list.ids.size(); ++i)
    places_[static_cast<std::size_t>(list.ids[i])] = {
        static_cast<std::int32_t>(number), static_cast<std::int16_t>(i), static_cast<std::int16_t>(sign)};
}

}  // namespace lcmslam
