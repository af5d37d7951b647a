// What this browser remembers. A page that was opened as a file may be forbidden to: then nothing is remembered.

export function recall(name) {
  try {
    return localStorage.getItem(`lcmslam-${name}`);
  } catch {
    return null;
  }
}

export function remember(name, value) {
  try {
    localStorage.setItem(`lcmslam-${name}`, value);
  } catch {
    // as above
  }
}
