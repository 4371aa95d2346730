"""Near-regular texture overlay [NRT]: split a photo of patterned cloth and lay a new texture."""
