#pragma once
// An array whose copies share what they have in common: copying costs O(1), changing one element
// O(log N) new memory at most, and nothing when no copy shares the path. So particles hold maps that
// differ in a few landmarks, and resampling never copies a map.
//
// A radix tree: leaves of 8 values (landmarks made together are seen together, so they share a leaf),
// inner nodes of 16 children. A node may be changed in place if and only if one array owns it.
// Not promised: two threads may not change arrays that share nodes at the same time.

#include <array>
#include <cstddef>
#include <memory>

namespace lcmslam {

template <class Value>
class PersistentArray {
 public:
  /// Null when nothing near the index was ever set; default values beside those that were.
  const Value* find(std::size_t index) const {
    if (index >= capacity(depth_)) return nullptr;
    const void* node = root_.get();
    for (int level = depth_; node && level > 0; --level)
      node = static_cast<const Inner*>(node)->children[digit(index, level)].get();
    return node ? &static_cast<const Leaf*>(node)->values[index % kLeaf] : nullptr;
  }

  /// The element for writing; other copies keep theirs.
  Value& edit(std::size_t index) {
    while (index >= capacity(depth_)) grow();
    Pointer* node = &root_;
    for (int level = depth_; level > 0; --level) node = &own<Inner>(*node).children[digit(index, level)];
    return own<Leaf>(*node).values[index % kLeaf];
  }

  /// Calls visit(index, before or null, after) for each element in a leaf of `after` that `before` does
  /// not share, ascending. Cost: the changed paths, not the size.
  template <class Visit>
  static void for_each_difference(const PersistentArray& before, const PersistentArray& after, Visit visit) {
    difference(before.root_.get(), before.depth_, after.root_.get(), after.depth_, 0, visit);
  }

  /// Calls visit(index, value) for every element of every leaf, ascending.
  template <class Visit>
  void for_each(Visit visit) const {
    for_each_difference(PersistentArray(), *this,
                        [&](std::size_t i, const Value*, const Value& value) { visit(i, value); });
  }

 private:
  static constexpr std::size_t kLeaf = 8, kInner = 16;
  using Pointer = std::shared_ptr<void>;
  struct Leaf {
    std::array<Value, kLeaf> values{};
  };
  struct Inner {
    std::array<Pointer, kInner> children;
  };

  static std::size_t capacity(int depth) { return kLeaf << (4 * depth); }
  static std::size_t digit(std::size_t index, int level) {
    return (index / (kLeaf << (4 * (level - 1)))) % kInner;
  }

  void grow() {
    if (root_) {
      auto top = std::make_shared<Inner>();
      top->children[0] = std::move(root_);
      root_ = std::move(top);
    }
    ++depth_;
  }

  template <class Node>
  static Node& own(Pointer& pointer) {
    if (!pointer)
      pointer = std::make_shared<Node>();
    else if (pointer.use_count() > 1)
      pointer = std::make_shared<Node>(*static_cast<const Node*>(pointer.get()));
    return *static_cast<Node*>(pointer.get());
  }

  template <class Visit>
  static void difference(const void* before, int depth_before, const void* after, int depth_after,
                         std::size_t first, Visit& visit) {
    if (!after || before == after) return;
    if (depth_before > depth_after) {  // the older array was larger: compare with its first part
      const void* part = before ? static_cast<const Inner*>(before)->children[0].get() : nullptr;
      difference(part, depth_before - 1, after, depth_after, first, visit);
    } else if (depth_after > 0) {
      const bool same_depth = depth_before == depth_after;
      for (std::size_t c = 0; c < kInner; ++c) {
        const void* part = nullptr;
        if (before && same_depth) part = static_cast<const Inner*>(before)->children[c].get();
        if (before && !same_depth && c == 0) part = before;
        difference(part, same_depth || c > 0 ? depth_after - 1 : depth_before,
                   static_cast<const Inner*>(after)->children[c].get(), depth_after - 1,
                   first + c * capacity(depth_after - 1), visit);
      }
    } else {
      const Leaf* old_leaf = static_cast<const Leaf*>(before);
      for (std::size_t i = 0; i < kLeaf; ++i)
        visit(first + i, old_leaf ? &old_leaf->values[i] : nullptr,
              static_cast<const Leaf*>(after)->values[i]);
    }
  }

  Pointer root_;
  int depth_ = 0;
};

}  // namespace lcmslam
