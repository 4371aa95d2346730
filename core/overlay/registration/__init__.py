"""The joint registration of geometry and shading, and the growth to the cloth's end [NRT sec. 3.2]."""
