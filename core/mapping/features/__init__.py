"""Features that move as one: the mapping that is as close to W as they allow, solved exactly  [FAT sec. 2]."""
