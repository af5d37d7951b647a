// lcm-gen copies the names of members into code of many languages, where a keyword does not compile.

#include <lcmslam/messages/schema.hpp>

#include <gtest/gtest.h>

#include <set>
#include <sstream>

namespace lcmslam {
namespace {

const std::set<std::string>& keywords() {
  static const std::set<std::string> words = [] {
    std::istringstream text(
        // C and C++
        "alignas alignof and and_eq asm auto bitand bitor bool break case catch char char8_t char16_t "
        "char32_t "
        "class co_await co_return co_yield compl concept const const_cast consteval constexpr constinit "
        "continue "
        "decltype default delete do double dynamic_cast else enum explicit export extern false float for "
        "friend "
        "goto if inline int long mutable namespace new noexcept not not_eq nullptr operator or or_eq private "
        "protected public register reinterpret_cast requires restrict return short signed sizeof static "
        "static_assert static_cast struct switch template this thread_local throw true try typedef typeid "
        "typename typeof union unsigned using virtual void volatile wchar_t while xor xor_eq "
        // Java
        "abstract assert boolean byte extends final finally implements import instanceof interface native "
        "null "
        "package strictfp super synchronized throws transient var yield "
        // Python
        "False None True as async await def del elif except exec from global in is lambda nonlocal pass "
        "print "
        "raise with "
        // Lua
        "end function local nil repeat then until "
        // C#
        "base checked decimal delegate event fixed foreach implicit internal lock object out override params "
        "readonly ref sbyte sealed stackalloc string uint ulong unchecked unsafe ushort");
    std::set<std::string> all;
    for (std::string word; text >> word;) all.insert(word);
    return all;
  }();
  return words;
}

TEST(MemberNames, AreNoKeywordsOfAnyLanguage) {
  ASSERT_EQ(keywords().count("from"), 1U);
  for (const MessageType* type : MessageType::all()) {
    EXPECT_EQ(keywords().count(type->name), 0U) << type->name;
    for (const MessageField& field : type->fields)
      EXPECT_EQ(keywords().count(field.name), 0U) << type->name << "." << field.name;
  }
}

}  // namespace
}  // namespace lcmslam
