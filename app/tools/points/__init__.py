"""Points under the pointer: gripping, selecting, moving several at once."""
